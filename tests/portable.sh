#!/bin/sh
# Are the pictures the same, bit for bit, whatever compiled and ran them? Builds tests/portable.c in many ways, runs each
# and compares the hashes it prints.  usage: portable.sh OUT
out=$1
mkdir -p "$out" || exit 1
reference= different=0 compared=0 skipped=0

have() { command -v "$1" > /dev/null 2>&1; }

# compare NAME ISA RUNNER COMPILER FLAG...: RUNNER is what runs the program, or "" for this machine
compare() {
    name=$1 isa=$2 runner=$3
    shift 3
    for tool in $1 ${runner%% *}; do
        if ! have "$tool"; then printf '%-36s skipped: no %s\n' "$name" "$tool"; skipped=$((skipped + 1)); return; fi
    done
    if ! "$@" tests/portable.c -o "$out/program" -lm -lpthread > "$out/log" 2>&1; then
        printf '%-36s does not build: %s\n' "$name" "$(head -n 1 "$out/log")"
        different=$((different + 1))
        return
    fi
    $runner "$out/program" $isa > "$out/hashes" 2>&1 || echo "exit code $?" >> "$out/hashes"
    if [ -z "$reference" ]; then
        reference=$out/reference
        cp "$out/hashes" "$reference"
        cat "$reference"
        merged=$(sed -n 's/^merged *//p' "$reference") whole=$(sed -n 's/^cornell *//p' "$reference")
        if [ "$merged" != "$whole" ]; then echo "two halves merged differ from the whole"; different=$((different + 1)); fi
        if grep -qvE '^[a-z]+ +[0-9a-f]{16}$' "$reference"; then echo "$name: not all pictures were drawn"; different=$((different + 1)); fi
    elif cmp -s "$reference" "$out/hashes"; then printf '%-36s equal\n' "$name"
    else
        printf '%-36s DIFFERS: %s\n' "$name" "$(diff "$reference" "$out/hashes" | sed -n 's/^> *//p' | tr -s ' ' | tr '\n' ',')"
        different=$((different + 1))
    fi
    compared=$((compared + 1))
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

rm -f "$out/program" "$out/log"
echo "portable: $compared builds compared, $different differ, $skipped skipped"
[ "$different" = 0 ] && [ "$compared" -gt 0 ]
