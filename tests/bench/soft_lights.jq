# SPDX-License-Identifier: MIT
# The tables of soft_lights.sh.
def error: . * 1e5 | round / 1e5;
def ms: round;
def ratio: if . >= 10 then round else . * 10 | round / 10 end;

"Room-soft at \(.size), \(.threads) threads, medians of \(.runs) runs; \(.povray); \(.machine); \(.date), \(.revision).",
. as $all | .references[] | .comparison as $comparison |
([$all.rows[] | select(.comparison == $comparison)]) as $rows |
([$rows[] | select(.program == "penumbra")]) as $penumbra |
"",
(if $comparison == "lights" then "### The lights alone: one camera ray a pixel" else "### Whole pictures, with anti-aliasing" end), "",
"RMSE between two references: POV-Ray \(.povray | error), Penumbra \(.penumbra | error); between the programs \(.between | error), with hard shadows \(.hard | error).", "",
"| POV-Ray | RMSE | ms | tracing | Penumbra, not worse | RMSE | ms | tracing | ms, ratio | tracing, ratio |",
"|---|---:|---:|---:|---|---:|---:|---:|---:|---:|",
($rows[] | select(.program == "povray") | . as $p |
    "| \(.setting) | \(.rmse | error) | \(.wall_ms | ms) | \(.trace_ms | ms) | " +
    ([$penumbra[] | select(.rmse <= $p.rmse)] | min_by(.wall_ms) |
        if . then "\(.setting) | \(.rmse | error) | \(.wall_ms | ms) | \(.trace_ms | ms) | \($p.wall_ms / .wall_ms | ratio) | \($p.trace_ms / .trace_ms | ratio) |"
        else "none | | | | | |" end)),
"",
([$rows[] | select(.program == "povray") | . as $p | [$penumbra[] | select(.rmse <= $p.rmse)] | min_by(.wall_ms) |
    {wall: (if . then $p.wall_ms / .wall_ms else 0 end), trace: (if . then $p.trace_ms / .trace_ms else 0 end)}] |
    "Least ratio: \(map(.wall) | min | ratio) of whole programs, \(map(.trace) | min | ratio) of tracing."),
"", "All rows of Penumbra:", "",
"| setting | RMSE | ms | tracing |", "|---|---:|---:|---:|",
($penumbra[] | "| \(.setting) | \(.rmse | error) | \(.wall_ms | ms) | \(.trace_ms | ms) |")
