#!/bin/sh
# Are the pictures the same, bit for bit, whatever compiled and ran them? Builds tests/portable.c in many ways, runs each
# and compares the hashes it prints.  usage: portable.sh OUT
out=$1
mkdir -p "$out" || exit 1
rm -f "$out"/[0-9]* "$out/reference"
count=0 reference=$out/reference

have() { command -v "$1" > /dev/null 2>&1; }

say() {                               # NUMBER NAME VERDICT
    printf '%-36s %s\n' "$2" "$3"
    echo "$3" > "$out/$1.verdict"
}
# build NUMBER NAME ISA RUNNER COMPILER FLAG...: RUNNER is what runs the program, or "" for this machine
build() {
    number=$1 name=$2 isa=$3 runner=$4
    shift 4
    for tool in $1 ${runner%% *}; do
        if ! have "$tool"; then say "$number" "$name" "skipped: no $tool"; return; fi
    done
    if ! "$@" tests/portable.c -o "$out/$number.program" -lm -lpthread > "$out/$number.log" 2>&1; then
        say "$number" "$name" "DOES NOT BUILD: $(head -n 1 "$out/$number.log")"
        return
    fi
    $runner "$out/$number.program" $isa > "$out/$number.hashes" 2>&1 || echo "exit code $?" >> "$out/$number.hashes"
    rm -f "$out/$number.program" "$out/$number.log"
    [ -f "$reference" ] || cp "$out/$number.hashes" "$reference"
    if cmp -s "$reference" "$out/$number.hashes"; then say "$number" "$name" equal
    else say "$number" "$name" "DIFFERS: $(diff "$reference" "$out/$number.hashes" | sed -n 's/^> *//p' | tr -s ' ' | tr '\n' ',')"
    fi
}
compare() {                           # two at a time, but the first alone: all others are held against it
    count=$((count + 1))
    build $count "$@" &
    if [ $((count % 2)) = 1 ]; then wait; fi
}

compare 'gcc -O2'                   ''     '' gcc -O2
compare 'gcc -O0'                   ''     '' gcc -O0
compare 'gcc -O1'                   ''     '' gcc -O1
compare 'gcc -O3'                   ''     '' gcc -O3
compare 'gcc -O3 -march=native'     ''     '' gcc -O3 -march=native
compare 'gcc -Os -std=c99'          ''     '' gcc -Os -std=c99
compare 'gcc -O2, no SIMD, no threads' ''  '' gcc -O2 -DPT_NO_SIMD -DPT_NO_THREADS
compare 'clang -O2'                 ''     '' clang -O2
compare 'clang -O0'                 ''     '' clang -O0
compare 'clang -O3 -march=native'   ''     '' clang -O3 -march=native
compare 'g++ -O2'                   ''     '' g++ -O2 -x c++
case $(uname -m) in
x86_64)
    compare 'gcc -O2, scalar'       scalar '' gcc -O2
    compare 'gcc -O2, sse2'         sse2   '' gcc -O2
    if grep -q avx2 /proc/cpuinfo 2> /dev/null; then compare 'gcc -O2, avx2' avx2 '' gcc -O2
    else printf '%-36s skipped: this machine has none\n' 'gcc -O2, avx2'; fi
    compare 'clang -O3 -march=native, scalar' scalar '' clang -O3 -march=native
    ;;
aarch64)
    compare 'gcc -O2, scalar'       scalar '' gcc -O2
    compare 'gcc -O2, neon'         neon   '' gcc -O2
    ;;
esac
compare 'aarch64'                   ''     'qemu-aarch64' aarch64-linux-gnu-gcc -O2 -static
compare 'aarch64, scalar'           scalar 'qemu-aarch64' aarch64-linux-gnu-gcc -O2 -static
compare 'armhf'                     ''     'qemu-arm'     arm-linux-gnueabihf-gcc -O2 -static
compare 'riscv64'                   ''     'qemu-riscv64' riscv64-linux-gnu-gcc -O2 -static
compare 's390x (big-endian)'        ''     'qemu-s390x'   s390x-linux-gnu-gcc -O2 -static

wait

different=$(cat "$out"/*.verdict | grep -c '^D')
skipped=$(cat "$out"/*.verdict | grep -c '^skipped')
cat "$reference"
merged=$(sed -n 's/^merged *//p' "$reference") whole=$(sed -n 's/^cornell *//p' "$reference")
if [ "$merged" != "$whole" ]; then echo "two halves merged differ from the whole"; different=$((different + 1)); fi
if grep -qvE '^[a-z]+ +[0-9a-f]{16}$' "$reference"; then echo "not all pictures were drawn"; different=$((different + 1)); fi
echo "portable: $((count - skipped)) builds compared, $different differ, $skipped skipped"
[ "$different" = 0 ] && [ "$count" -gt "$skipped" ]
