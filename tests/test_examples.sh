#!/bin/sh
# The examples as a stranger meets them: good runs end in a picture, bad input in one clear line, the right exit code and
# no file.  usage: test_examples.sh OUT, where the built examples are
out=$1
tool=$out/render_obj
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT
passed=0 failed=0

pass() { passed=$((passed + 1)); }
fail() { failed=$((failed + 1)); echo "FAIL: $*"; }

# bad CODE WORD ARGUMENT...: exits with CODE, says one line on stderr with WORD in it, nothing on stdout, leaves no new file
bad() {
    code=$1 word=$2
    shift 2
    before=$(ls -A "$tmp")
    timeout 60 "$tool" "$@" > "$tmp/.stdout" 2> "$tmp/.stderr" < /dev/null
    got=$?
    lines=$(wc -l < "$tmp/.stderr")
    said=$(cat "$tmp/.stderr")
    if [ $got -ne "$code" ]; then fail "render_obj $*: exit code $got, not $code; it said: $said"
    elif [ "$lines" -ne 1 ]; then fail "render_obj $*: $lines lines on stderr, not 1: $said"
    elif [ -s "$tmp/.stdout" ]; then fail "render_obj $*: something on stdout"
    elif ! grep -qF -- "$word" "$tmp/.stderr"; then fail "render_obj $*: '$word' is not in: $said"
    elif [ "$(ls -A "$tmp")" != "$before" ]; then fail "render_obj $*: left a file: $(ls -A "$tmp")"
    else pass; fi
}
# good FILE COMMAND...: exits with 0, nothing on stderr, FILE is there; it is removed afterwards
good() {
    file=$1
    shift
    timeout 120 "$@" > "$tmp/.stdout" 2> "$tmp/.stderr" < /dev/null
    got=$?
    if [ $got -ne 0 ]; then fail "$*: exit code $got: $(head -n 1 "$tmp/.stderr")"
    elif [ ! -s "$file" ]; then fail "$*: no picture"
    else pass; fi
    rm -f "$file"
}
check() { if "$@"; then pass; else fail "$*"; fi; }

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > "$tmp/one.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 901\n' > "$tmp/index.obj"
printf 'v 0 0 0\nv 1 zero 0\nv 0 1 0\nf 1 2 3\n' > "$tmp/word.obj"
printf 'v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n' > "$tmp/nan.obj"
printf 'v 0 0 0\nv 1 0 0\nf 1 2\n' > "$tmp/two.obj"
printf 'v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n' > "$tmp/point.obj"
printf 'v 1 1 1\n' > "$tmp/nofaces.obj"
: > "$tmp/empty.obj"
head -c 4096 "$tool" > "$tmp/binary.obj"
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n\002\002' > "$tmp/short.hdr"
printf 'not a picture' > "$tmp/text.hdr"
printf 'PF\n-3 4\n-1\n' > "$tmp/negative.pfm"
: > "$tmp/.stdout"; : > "$tmp/.stderr"
one=$tmp/one.obj
pic=$tmp/picture.ppm

# usage
bad 2 'no model'
bad 2 'no model'      ''
bad 2 '--wonder'      "$one" --wonder
bad 2 '-x'            "$one" -x
bad 2 'two models'    "$one" "$one"
bad 2 'needs a value' "$one" --spp
bad 2 'needs a value' "$one" --out --quiet
for n in 12abc -4 0 1.5 1e3 0x10 '' ' 7' 99999999999999999999 1000001; do bad 2 "--spp $n" "$one" --out "$pic" --spp "$n"; done
for n in 0 -1 2x 1025;           do bad 2 "--threads $n" "$one" --out "$pic" --threads "$n"; done
for n in 0 -1 10001 ten;         do bad 2 "--depth $n"   "$one" --out "$pic" --depth "$n"; done
for n in -1 1.0 18446744073709551616 0x1 ''; do bad 2 "--seed $n" "$one" --out "$pic" --seed "$n"; done
for n in 0x5 5x0 5 5x 'x5' 5x5x5 -5x5 5x-5 100000x100000 16384x16384 1e2x5 '5 x5' 5X5 99999999999999999999x5; do
    bad 2 "--size $n" "$one" --out "$pic" --size "$n"
done
for n in 0 171 nan inf abc 30deg; do bad 2 "--fov $n"        "$one" --out "$pic" --fov "$n"; done
for n in 91 -91 1e999;            do bad 2 "--elevation $n"  "$one" --out "$pic" --elevation "$n"; done
for n in 361 x;                   do bad 2 "--azimuth $n"    "$one" --out "$pic" --azimuth "$n"; done
for n in 361 -1e9;                do bad 2 "--rotate-env $n" "$one" --out "$pic" --rotate-env "$n"; done
for n in 31 -31 1,0 --;           do bad 2 '--exposure'      "$one" --out "$pic" --exposure "$n"; done
for n in 1 1,1 1,1,1,1 2,0,0 -1,0,0 a,b,c 1,,1 ''; do bad 2 "--color $n" "$one" --out "$pic" --color "$n"; done
for n in 1 1,1 2,0,0 ''; do bad 2 "--patches $n" "$one" --out "$pic" --patches "$n"; done
for n in -1 1.1 x '';     do bad 2 "--roughness $n" "$one" --out "$pic" --roughness "$n"; done
for n in 0 181 flat '';   do bad 2 "--smooth $n" "$one" --out "$pic" --smooth "$n"; done
bad 2 '--color'         "$one" --out "$pic" --material gold --color 1,1,1
bad 2 '--material '     "$one" --out "$pic" --material ''
bad 2 '--material wood' "$one" --out "$pic" --material wood
bad 2 '--curve aces'    "$one" --out "$pic" --curve aces
bad 2 '.ppm'            "$one" --out "$tmp/picture.jpg"
bad 2 '.ppm'            "$one" --out "$tmp/picture"
bad 2 '.ppm'            "$one" --out .ppm
bad 2 'input'           "$one" --env "$tmp/text.hdr" --out "$tmp/text.hdr"

# files
bad 1 "$tmp/none.obj"     "$tmp/none.obj"     --out "$pic"
bad 1 "$tmp"              "$tmp"              --out "$pic"
bad 1 "$tmp/index.obj:4"  "$tmp/index.obj"    --out "$pic"
bad 1 "$tmp/word.obj:2"   "$tmp/word.obj"     --out "$pic"
bad 1 "$tmp/nan.obj:2"    "$tmp/nan.obj"      --out "$pic"
bad 1 "$tmp/two.obj:3"    "$tmp/two.obj"      --out "$pic"
bad 1 'one point'         "$tmp/point.obj"    --out "$pic"
bad 1 'nofaces.obj'       "$tmp/nofaces.obj"  --out "$pic"
bad 1 'empty.obj'         "$tmp/empty.obj"    --out "$pic"
bad 1 'binary.obj'        "$tmp/binary.obj"   --out "$pic"
bad 1 "$tmp/none.hdr"     "$one" --env "$tmp/none.hdr"     --out "$pic"
bad 1 "$tmp"              "$one" --env "$tmp"              --out "$pic"
bad 1 'short.hdr'         "$one" --env "$tmp/short.hdr"    --out "$pic"
bad 1 'text.hdr'          "$one" --env "$tmp/text.hdr"     --out "$pic"
bad 1 'negative.pfm'      "$one" --env "$tmp/negative.pfm" --out "$pic"
printf 'PF\n1 1\n-1.0\n\000\000\300\177\000\000\200\077\000\000\200\077' > "$tmp/nan.pfm"
printf 'PF\n1 1\n-1.0\n\000\000\200\277\000\000\200\077\000\000\200\077' > "$tmp/below.pfm"
printf 'PF\n1 1\n-1.0\n\377\377\177\177\000\000\200\077\000\000\200\077' > "$tmp/bright.pfm"
for map in nan below bright; do bad 1 "$tmp/$map.pfm" "$one" --env "$tmp/$map.pfm" --out "$pic"; done
bad 1 'one.obj'           "$one" --env "$one"              --out "$pic"
bad 1 'cannot write'      "$one" --out "$tmp/no/such/place.ppm"
bad 1 'cannot write'      "$one" --out "$one/below_a_file.ppm"
mkdir "$tmp/directory.ppm"
bad 1 'cannot write'      "$one" --out "$tmp/directory.ppm"
if [ "$(id -u)" != 0 ]; then
    mkdir "$tmp/locked"; chmod 555 "$tmp/locked"
    bad 1 'cannot write' "$one" --out "$tmp/locked/picture.ppm"
    printf 'old' > "$tmp/old.ppm"; chmod 444 "$tmp/old.ppm"
    bad 1 'cannot write' "$one" --out "$tmp/old.ppm"
fi

# materials of the file, and their pictures
plain() { printf 'mtllib %s.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n' "$1" > "$tmp/$1.obj"; }
for m in red painted lost broken; do plain $m; done
printf 'newmtl m\nKd 0.8 0.1 0.1\n' > "$tmp/red.mtl"
printf 'newmtl m\nmap_Kd paint.ppm\nmap_Bump paint.ppm\n' > "$tmp/painted.mtl"
printf 'newmtl m\nmap_Kd none.ppm\n' > "$tmp/lost.mtl"
printf 'newmtl m\nmap_Kd text.hdr\n' > "$tmp/broken.mtl"
printf 'P6\n2 1\n255\n\377\000\000\000\377\000' > "$tmp/paint.ppm"
printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' > "$tmp/one.ply"
head -n 9 "$tmp/one.ply" > "$tmp/short.ply"
bad 1 'none.ppm'          "$tmp/lost.obj"   --out "$pic" --quiet
bad 1 'text.hdr'          "$tmp/broken.obj" --out "$pic" --quiet
bad 1 'short.ply'         "$tmp/short.ply"  --out "$pic"

# what works
check sh -c "'$tool' --help | grep -q 'exit codes'"
check sh -c "'$tool' --help nonsense --spp x > /dev/null"
small='--size 16x12 --spp 2'
# shellcheck disable=SC2086   # $small is several words
{
good "$pic"         "$tool" "$one" --out "$pic" $small
good "$tmp/p.hdr"   "$tool" "$one" --out "$tmp/p.hdr" $small --ground --material glass
good "$tmp/p.png"   "$tool" "$one" --out "$tmp/p.png" $small --curve false
good "$tmp/p.pfm"   "$tool" "$one" --out "$tmp/p.pfm" $small --material mirror --color 1,0.5,0 --exposure -1 --fov 50
good "$tmp/p.ppm"   "$tool" --seed 18446744073709551615 --threads 3 --depth 1 --azimuth -90 --elevation 90 $small --out "$tmp/p.ppm" "$one"
good "$pic"         "$tool" "$tmp/one.ply" --out "$pic" $small --smooth 180 --material gold --roughness 0.3
good "$pic"         "$tool" "$tmp/painted.obj" --out "$pic" $small
good "$pic"         "$tool" "$tmp/lost.obj" --out "$pic" $small --material paint --color 0,0,1 --patches 1,1,1
for m in red painted; do "$tool" "$tmp/$m.obj" $small --out "$tmp/$m.ppm" --quiet; "$tool" "$tmp/$m.obj" $small --out "$tmp/$m.2.ppm" --quiet --material diffuse; done
check sh -c "! cmp -s '$tmp/red.ppm' '$tmp/red.2.ppm'"              # the file's materials show
check sh -c "! cmp -s '$tmp/painted.ppm' '$tmp/painted.2.ppm'"
check cmp -s "$tmp/red.2.ppm" "$tmp/painted.2.ppm"
"$tool" "$one" $small --out "$pic" --quiet > "$tmp/.stdout" 2> "$tmp/.stderr"
check test ! -s "$tmp/.stdout" -a ! -s "$tmp/.stderr"
check test "$(wc -c < "$pic")" = $((16 * 12 * 3 + 13))              # the header is "P6\n16 12\n255\n"
"$tool" "$one" $small --out "$tmp/2.ppm" --quiet --threads 1
check cmp -s "$pic" "$tmp/2.ppm"                                   # the number of threads does not show
"$tool" "$one" $small --out "$tmp/2.ppm" --quiet --seed 1
check sh -c "! cmp -s '$pic' '$tmp/2.ppm'"                          # the seed does
}

# Ctrl-C: nothing is written, and what was there before stays
printf 'old' > "$tmp/old2.ppm"
# setsid sh: an asynchronous command of a non-interactive shell ignores SIGINT, so the tool must be told by its own process
cat > "$tmp/.interrupt.sh" <<'END'
"$1" "$2" --size 512x512 --spp 100000 --out "$3" > "$4" 2>&1 &
pid=$!
sleep 1
kill -INT $pid
wait $pid
END
sh "$tmp/.interrupt.sh" "$tool" "$one" "$tmp/old2.ppm" "$tmp/.stderr"
check test $? = 130
check grep -q 'nothing was written' "$tmp/.stderr"
check test "$(cat "$tmp/old2.ppm")" = old

echo "$passed passed, $failed failed"
[ $failed = 0 ]
