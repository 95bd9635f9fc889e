#!/bin/sh
# make figures: the pictures of the README, with many samples, as OUT/figures/*.png. With ImageMagick's convert here, they
# also go to examples/images/*.jpg.  usage: [SPP=N] figures.sh OUT EXAMPLE...   (SPP: samples a pixel, for all alike)
# Two more show meshes and maps from ../shared/data, where that is.
out=$1
shift
figures=$out/figures
mkdir -p "$figures" examples/images || exit 1

publish() {                           # NAME KILOBYTES OPTIONS...
    if command -v convert > /dev/null; then
        name_=$1 limit=$2
        shift 2
        convert "$figures/$name_.png" "$@" -strip -interlace Plane -define jpeg:extent="${limit}KB" "examples/images/$name_.jpg"
        set -- "$name_"
    fi
    echo "$figures/$1.png"
}
samples() {                           # NAME: what is hard to light needs more
    if [ -n "$SPP" ]; then echo "$SPP"; return; fi
    case $1 in 02* | 12* | 15*) echo 1024;; 03* | 13*) echo 256;; *) echo 512;; esac
}
model() {                             # NAME MESH MAP KILOBYTES OPTIONS...: a mesh of ../shared/data under one of its maps
    name_=$1 mesh=../shared/data/meshes/$2 map=../shared/data/env/$3 limit_=$4
    shift 4
    if [ ! -f "$mesh" ] || [ ! -f "$map" ]; then echo "$name_: skipped, no $mesh or no $map"; return; fi
    [ -s "$figures/$name_.png" ] && [ "$figures/$name_.png" -nt "$out/render_obj" ] && return
    "$out/render_obj" "$mesh" --env "$map" --out "$figures/$name_.png" --ground --size 600x600 --spp "$(samples "$name_")" --quiet "$@" &&
        publish "$name_" "$limit_" -resize 400x400
}
for name in "$@"; do
    [ -s "$figures/$name.png" ] && [ "$figures/$name.png" -nt "examples/$name.c" ] && continue      # drawn before
    sed "s/\.spp = [0-9][0-9]*/.spp = $(samples "$name")/; s|\"../pt.h\"|\"pt.h\"|" "examples/$name.c" > "$figures/$name.c"
    if [ "$name" = 07_progressive ]; then sed 's/total == [0-9]*/total >= 256/' "examples/$name.c" | sed 's|"../pt.h"|"pt.h"|' > "$figures/$name.c"; fi
    ${CC:-cc} -O2 -I. "$figures/$name.c" -o "$figures/$name" -lm -lpthread && "$figures/$name" "$figures/$name.png" > "$figures/log" &&
        publish "$name" 80 -resize 400x400 || exit 1
done
if ! [ -s "$figures/knot.png" ] || [ "$out/render_obj" -nt "$figures/knot.png" ]; then
    "$out/render_obj" "$out/knot.obj" --env "$out/sky.hdr" --out "$figures/knot.png" --ground --size 900x560 --spp "${SPP:-256}" \
        --fov 22 --azimuth -60 --elevation 38 --color 0.75,0.3,0.1 && publish knot 190 || exit 1
fi
model spot spot.obj forest.hdr 80 --smooth 180 --color 0.78,0.73,0.65 --patches 0.05,0.03,0.02 --azimuth 220 --elevation 14 --fov 24 ||
    exit 1
model suzanne suzanne.obj forest.hdr 80 --smooth 180 --material paint --color 0.55,0.02,0.03 --azimuth 25 --elevation 4 --fov 24 \
    --rotate-env 180 --curve filmic || exit 1
