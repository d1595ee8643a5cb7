# SPDX-License-Identifier: MIT
# Shared by the scripts of this folder: a daemon with a picture of 10 MB and a job that does not end, and
# the values that `load` prints.
load=$build/tests/load/load

# Starts a daemon without a worker, so that its job does not end. Sets $api (a process id), $port, $job and
# $picture (paths).
load_start() {
    daemon_start
    submit '{"scene": "builtin:spheres", "render": {"width": 1000, "height": 834}}'
    curl -s -o /dev/null "$url$job?wait=60"
    picture="$job/image?format=pfm"
    curl -s -o /dev/null "$url$picture" # makes and stores it
    daemon_stop
    daemon_start --role api
    api=$(pgrep -P "$daemon" -x penumbrad-api)
    port=${url##*:}
    submit '{"scene": "builtin:spheres"}'
}

value() { # NAME: of the last output, in $work/values
    awk -v name="$1" '$1 == name {print $2}' "$work/values"
}

below() { # NAME LIMIT: checks a value
    if [ -n "$(value "$1")" ] && awk -v a="$(value "$1")" -v b="$2" 'BEGIN {exit !(a < b)}'; then
        ok "$1 below $2"
    else
        not_ok "$1" "is $(value "$1"), expected less than $2"
    fi
}
