#!/bin/sh
# make figures: the pictures of the README, with many samples, as OUT/figures/*.png. With ImageMagick's convert here, they
# also go to examples/images/*.jpg.  usage: figures.sh OUT EXAMPLE...
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
    case $1 in 02*) echo 1024;; 03*) echo 256;; *) echo 512;; esac
}
for name in "$@"; do
    [ -s "$figures/$name.png" ] && [ "$figures/$name.png" -nt "examples/$name.c" ] && continue      # drawn before
    sed "s/\.spp = [0-9][0-9]*/.spp = $(samples "$name")/; s|\"../pt.h\"|\"pt.h\"|" "examples/$name.c" > "$figures/$name.c"
    if [ "$name" = 07_progressive ]; then sed 's/total == [0-9]*/total >= 256/' "examples/$name.c" | sed 's|"../pt.h"|"pt.h"|' > "$figures/$name.c"; fi
    ${CC:-cc} -O2 -I. "$figures/$name.c" -o "$figures/$name" -lm -lpthread && "$figures/$name" "$figures/$name.png" > "$figures/log" &&
        publish "$name" 80 -resize 400x400 || exit 1
done
"$out/render_obj" "$out/knot.obj" --env "$out/sky.hdr" --out "$figures/knot.png" --ground --size 900x560 --spp 256 \
    --fov 22 --azimuth -60 --elevation 38 --color 0.75,0.3,0.1 && publish knot 190
