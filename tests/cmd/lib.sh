# SPDX-License-Identifier: MIT
# Helpers of the tests of the programs, in addition to tests/e2e/lib.sh: running a command and checking
# its exit code and output, and finding the processes of a daemon.
. "$(dirname "$0")/../e2e/lib.sh"
root=$(cd "$(dirname "$0")/../.." && pwd)
penumbra=$build/penumbra
unset PENUMBRA_URL PENUMBRA_TOKEN PENUMBRA_CA PENUMBRA_LISTEN PENUMBRA_STORE PENUMBRA_ROLE PENUMBRA_THREADS \
    PENUMBRA_MAX_TIMEOUT PENUMBRA_MAX_SECONDS PENUMBRA_MAX_PIXELS PENUMBRA_MAX_SAMPLES \
    PENUMBRA_MAX_PRIORITY PENUMBRA_MAX_QUEUE PENUMBRA_MAX_CLIENT_QUEUE PENUMBRA_TOKENS PENUMBRA_TLS_CERT \
    PENUMBRA_TLS_KEY PENUMBRA_PLAIN_HTTP PENUMBRA_CORS PENUMBRA_CONFIG PENUMBRA_LOG_FILE PENUMBRA_LOG_FORMAT \
    PENUMBRA_LOG_LEVEL PENUMBRA_UNTIL_IDLE \
    STATE_DIRECTORY
export XDG_CONFIG_HOME="$work/config" # no token of the user's

# check NAME COMMAND…: the command succeeds.
check() {
    name=$1
    shift
    if "$@" >"$work/output" 2>&1; then
        ok "$name"
    else
        not_ok "$name" "exit $? of: $* $(head -c 600 "$work/output")"
    fi
}

# exits NAME CODE COMMAND…: the command ends with this exit code. Its output is in $work/stdout and
# $work/stderr afterwards.
exits() {
    name=$1
    want=$2
    shift 2
    "$@" >"$work/stdout" 2>"$work/stderr" </dev/null
    got=$?
    if [ "$got" -eq "$want" ]; then
        ok "$name"
    else
        not_ok "$name" "exit $got, not $want, of: $* $(head -c 600 "$work/stderr")"
    fi
}

# prints NAME STREAM TEXT: the output of the last command to stdout or stderr contains the text.
prints() {
    if grep -qF -- "$3" "$work/$2"; then
        ok "$1"
    else
        not_ok "$1" "no \"$3\" in: $(head -c 600 "$work/$2")"
    fi
}

# samples_lasting MS ARGUMENT…: prints the samples per pixel with which the render of these arguments takes
# about so long. The shortest of three renders counts, since one alone may have been held up.
samples_lasting() {
    ms=$1
    shift
    for _ in 1 2 3; do
        "$penumbra" render "$@" -q --stats "$work/stats.json" && cat "$work/stats.json"
    done | jq -s "map(.timing.render_ms) | $ms / (min + 1) | floor + 1"
}

# child ROLE: prints the process id of the daemon's child in that role (api or work).
child() {
    pgrep -P "$daemon" -x "penumbrad-$1"
}

# gone PID…: whether none of the processes exists any more. A zombie counts as gone, since its new
# parent may collect it later.
gone() {
    for pid; do
        case $(ps -o stat= -p "$pid") in
        '' | Z*) ;;
        *) return 1 ;;
        esac
    done
}

# done_runs ID: prints how many runs of a study are done; has_runs ID COUNT: whether they are so many.
done_runs() {
    curl -s "$url/v1/jobs/$1" | jq .progress.done
}
has_runs() {
    [ "$(done_runs "$1")" -ge "$2" ]
}

# goes_beyond ID COUNT: whether a study has done more runs, or all it has.
goes_beyond() {
    curl -s "$url/v1/jobs/$1" | jq -e ".progress.done > $2 or .state == \"succeeded\"" >"$work/output"
}

# csv FILE NAME: the values of a column.
csv() {
    awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) at = i } NR > 1 { print $at }' "$1"
}

# check_goes_on ID COUNT: kills the worker of a study after COUNT runs, more than one of which it must have
# kept, and checks that the next worker does not begin with the first again. Runs are reported before they are
# kept, so the worker is killed after one more report.
check_goes_on() {
    within has_runs "$1" "$2" || not_ok "the study whose worker is killed" "does not run: $(done_runs "$1")"
    within goes_beyond "$1" "$(done_runs "$1")"
    kill -KILL "$(child work)"
    killed=$(done_runs "$1")
    least=$killed now=$killed
    tries=$((hang * 20))
    while ! goes_beyond "$1" "$killed" && [ "$tries" -gt 0 ]; do
        sleep 0.05
        now=$(done_runs "$1")
        [ "$now" -ge "$least" ] || least=$now
        tries=$((tries - 1))
    done
    if [ "$least" -ge 1 ] && [ "$tries" -gt 0 ]; then
        ok "the next worker goes on with the study"
    else
        not_ok "the next worker goes on with the study" "killed after $killed runs, then $least, then $now"
    fi
    expect "a killed worker is not charged to its study" "$(curl -s "$url/v1/jobs/$1" | jq .attempts)" 1
}

# check_gives_way ID COUNT: a job of higher priority comes between two runs of a study, after COUNT of them.
check_gives_way() {
    within has_runs "$1" "$2" || not_ok "the study that is outranked" "does not run: $(done_runs "$1")"
    exits "a job of higher priority does not wait for the study" 0 "$penumbra" submit builtin:spheres --set width=20 \
        --set height=20 --priority 5 --wait -q
    expect "which is not done" "$(curl -s "$url/v1/jobs/$1" | jq -r .state)" running
    within has_runs "$1" $(($2 + 2)) && ok "the study goes on after it" || not_ok "the study goes on after it" "$(done_runs "$1")"
    expect "the interruption is not charged to the study" "$(curl -s "$url/v1/jobs/$1" | jq .attempts)" 1
}
