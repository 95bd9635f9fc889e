#!/bin/sh
# A race with Blender's Cycles, by turns: pictures of both, and a table of how they compare. From the repository's root:
#   tests/bench/race_cycles.sh [--size N] [--spp N] [--reference N] [--rounds N] [--wall] [SCENE...]
# Two threads each. Seconds are the processor's, which other work on the machine disturbs little; with --wall, the clock's.
# The goal's own setting, on a machine with nothing else to do: --size 512 --wall. Its references take some three hours, but
# once: they stay in out/reference.
size=128 spp=64 reference=8192 rounds=8 wall= scenes=
usage() { sed -n '3,7s/^# *//p' "$0"; exit "$1"; }
while [ $# -gt 0 ]; do
    case $1 in
        --size|--spp|--reference|--rounds)
            case ${2:-x} in *[!0-9]*|0*) usage 1 ;; esac
            eval "${1#--}=\$2"; shift ;;
        --wall) wall=wall ;;
        cornell|bunny_sunset|metal_bunny|fog|fog_lamp) scenes="$scenes $1" ;;
        --help) usage 0 ;;
        *) usage 1 ;;
    esac
    shift
done
command -v blender >/dev/null || { echo 'race_cycles: skipped, there is no blender'; exit 0; }
: "${scenes:=cornell bunny_sunset metal_bunny fog fog_lamp}"

here=tests/bench out=out/race/${size}x$spp
mkdir -p "$out" out/reference
${CC:-cc} -O2 $here/race_cycles.c -o out/race_cycles -lm -lpthread || exit 1
ours() { out/race_cycles render "$out" $size $spp $reference "$@"; }
cycles() {
    blender -b --factory-startup -t 2 --python-exit-code 1 -P $here/race_cycles.py -- "$out" $size $spp $reference "$@" \
        >"$out/blender.log" 2>&1 || { tail -5 "$out/blender.log"; return 1; }
}
rm -f "$out/seconds.csv"
for scene in $scenes; do
    round=0                                              # of the references
    while [ $round -le $rounds ]; do
        ours $round $scene && cycles $round $scene || exit 1
        round=$((round + 1))
    done
done
out/race_cycles table "$out" $size $spp $reference $wall
