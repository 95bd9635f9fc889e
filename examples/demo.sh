#!/bin/sh
# make demo: draws numbered examples, then, with render_obj, a mesh under an HDR sky.
# usage: demo.sh OUT EXAMPLE...
out=$1
shift
count=$(($# + 1)) n=0 pictures=
start=$(date +%s)

draw() {                              # NAME COMMAND...: the command draws OUT/NAME.png
    name=$1
    shift
    n=$((n + 1))
    printf '[%2d/%d] %3d s  %s\n' $n $count $(($(date +%s) - start)) "$name"
    "$@" || { echo "demo: $name failed" >&2; exit 1; }
    pictures="$pictures $out/$name.png"
}
for example in "$@"; do draw "$example" "$out/$example" "$out/$example.png"; done
draw knot "$out/render_obj" "$out/knot.obj" --env "$out/sky.hdr" --out "$out/knot.png" --ground --elevation 35 --spp 16 \
    --color 0.8,0.35,0.12

echo "all drawn in $(($(date +%s) - start)) s:"
for picture in $pictures; do echo "  $picture"; done
