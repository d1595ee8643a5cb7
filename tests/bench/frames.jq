# The Markdown of frames.json: times of whole programs, then numbers of rays beside the published ones.
def ms: if . == null then "–" elif . < 100 then (. * 10 | round / 10 | tostring) else (round | tostring) end;
def times: if . == null then "–" else (. * 100 | round / 100 | tostring) + "×" end;
def over($a; $b): if $a and $b then $a / $b else null end;
def mean: if length == 0 then null else (map(log) | add / length | exp) end;
def haines: ["balls", "gears", "lattice", "mount", "rings", "teapot", "tetra"];
# Haines' Readme, version 3.14: eye rays, reflected, refracted, shadow rays. None for the lattice.
def published: {balls: [263169, 175095, 0, 954368], gears: [263169, 304643, 207564, 2246955],
    mount: [263169, 354769, 354769, 412922], rings: [263169, 315236, 0, 1085002],
    teapot: [263169, 225248, 0, 407656], tetra: [263169, 0, 0, 46112]};
def percent($mine; $his): if $his == 0 then (if $mine == 0 then "0" else "–" end)
    else (($mine / $his - 1) * 1000 | round / 10 | tostring) + " %" end;
. as $all |
([.rows[].scene] | reduce .[] as $s ([]; if index([$s]) then . else . + [$s] end)) as $scenes |
([.rows[].threads] | unique) as $threads |
def time($scene; $n; $program):
    [$all.rows[] | select(.scene == $scene and .threads == $n and .program == $program) | .wall_ms][0];
def gain($scene; $n): over(time($scene; $n; "povray"); time($scene; $n; "penumbra"));
"Whole programs by the clock, milliseconds, medians of \(.runs) interleaved runs; \(.date), revision \(.revision), \(.machine), \(.isa).",
"",
"| scene | \([$threads[] | "\(.) thread\(if . > 1 then "s" else "" end)", "POV-Ray", "gain"] | join(" | ")) | \($threads[-1]) over \($threads[0]) |",
"|---|" + ([$threads[] | "---:|---:|---:|"] | add) + "---:|",
($scenes[] as $s | "| `\($s)` | \([$threads[] as $n | (time($s; $n; "penumbra") | ms), (time($s; $n; "povray") | ms), (gain($s; $n) | times)] | join(" | ")) | \(over(time($s; $threads[0]; "penumbra"); time($s; $threads[-1]; "penumbra")) | times) |"),
"| geometric mean of Haines’ scenes | \([$threads[] as $n | "", "", ([$scenes[] | select(IN(haines[])) | gain(.; $n) | select(.)] | mean | times)] | join(" | ")) | |",
"",
"Rays of Haines’ scenes, and how far they are from the numbers that he published (his version 3.14):",
"",
"| scene | eye | reflected | | transmitted | | shadow | |",
"|---|---:|---:|---:|---:|---:|---:|---:|",
(.rays[] | select(.scene | IN(haines[])) | .rays as $r | published[.scene] as $p |
    "| `\(.scene)` | \($r.primary) | \($r.reflection) | \(if $p then percent($r.reflection; $p[1]) else "" end) | \($r.transmission) | \(if $p then percent($r.transmission; $p[2]) else "" end) | \($r.shadow) | \(if $p then percent($r.shadow; $p[3]) else "" end) |"),
"",
"His refracted rays in `gears` are as many as if none were totally reflected: his reflected rays without his refracted ones are those of the ground. For `lattice` he published none."
