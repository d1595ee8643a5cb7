# SPDX-License-Identifier: MIT
# What the benchmarks' scripts share: the scenes' names and sizes, and how one is made. Sourced; `root`
# and `build` are set.

# Scenes that are built in, rooms, and those of Haines' Standard Procedural Databases.
BUILTIN='builtin:room builtin:room-soft builtin:forest builtin:teapot builtin:spheres builtin:soft-shadow'
ROOMS='parlour soft-room'
HAINES='balls gears lattice mount rings teapot tetra'

# Small scenes, and how many primitives they have.
SMALL='row:2 row:9 row:40 tubes:3 tubes:9 tubes:40 cones:3 cones:9 cones:40'

# make_scene NAME FILE [WIDTH HEIGHT]: writes a scene, at another size if that is given. NAME may be
# NAME:PRIMITIVES. One sample per
# pixel, so that another renderer does the same work.
make_scene() {
    case $1 in
    builtin:*) "$build/penumbra" scenes "${1#builtin:}" ;;
    *:*) "$build/tests/bench/make_scene" "${1%:*}" "${1#*:}" ;;
    *) "$build/tests/bench/make_scene" "$1" ;;
    esac | if [ "${3:-}" ]; then
        jq -c --argjson w "$3" --argjson h "$4" '.render += {width: $w, height: $h, samples_per_pixel: 1}'
    else
        jq -c '.render += {samples_per_pixel: 1}'
    fi >"$2"
}

# The size at which a scene is timed, if not its own: SIZE=WIDTHxHEIGHT in the environment, or smaller
# ones, as soft shadows take other renderers minutes.
timed_size() {
    case ${SIZE:-$1} in
    [0-9]*x[0-9]*) echo "${SIZE%x*} ${SIZE#*x}" ;;
    builtin:room-soft) echo 150 210 ;;
    builtin:soft-shadow) echo 400 250 ;;
    soft-room) echo 100 150 ;;
    esac
}

# The machine, as a line of text.
machine() {
    printf '%s, %s cores, %s' "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)" "$(nproc)" \
        "$(uname -sr)"
}
