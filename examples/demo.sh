#!/bin/sh
# make demo: draws every numbered example, then a mesh under an HDR sky in two materials with render_obj.
# usage: demo.sh OUT EXAMPLE...
out=$1
shift
count=$(($# + 2)) n=0 pictures=
start=$(date +%s)

draw() {                              # NAME COMMAND...: the command draws OUT/NAME.ppm
    name=$1
    shift
    n=$((n + 1))
    printf '[%2d/%d] %3d s  %s\n' $n $count $(($(date +%s) - start)) "$name"
    "$@" || { echo "demo: $name failed" >&2; exit 1; }
    pictures="$pictures $out/$name.ppm"
}
knot() {                              # NAME OPTIONS...
    name=$1
    shift
    draw "$name" "$out/render_obj" "$out/knot.obj" --env "$out/sky.hdr" --out "$out/$name.ppm" --ground --elevation 35 "$@"
}

for example in "$@"; do draw "$example" "$out/$example" "$out/$example.ppm"; done
knot knot       --spp 32 --color 0.8,0.35,0.12
knot knot_glass  --spp 32 --material glass

echo "all drawn in $(($(date +%s) - start)) s:"
for picture in $pictures; do echo "  $picture"; done
