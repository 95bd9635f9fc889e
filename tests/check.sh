#!/bin/sh
# The compiler matrix, the symbols an object needs, and the tests under sanitizers. One line a step.
# usage: check.sh OUT
out=$1
mkdir -p "$out" || exit 1
: > "$out/failed"; : > "$out/skipped"                # a line for each; files, for some steps run side by side
log=$out/log

have() { command -v "$1" > /dev/null 2>&1; }
say()  { printf '%-72s %s\n' "$1" "$2"; }
# step NAME COMMAND...: quiet when all is well, otherwise the first lines of what the command said
step() {
    step_name=$1
    shift
    if "$@" > "$log" 2>&1 < /dev/null; then say "$step_name" ok; return; fi
    { say "$step_name" FAILED; sed 's/^/    /' "$log" | tail -n 15; } > "$log.shown"
    cat "$log.shown"
    echo "$step_name" >> "$out/failed"
}
skip() { say "$1" "skipped: $2"; echo "$1" >> "$out/skipped"; }

# ---- the header alone, in both languages, with every switch, without a single warning
warnings='-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wundef -Wcast-qual -Wdouble-promotion -Werror'
printf '#define PT_IMPLEMENTATION\n#include "pt.h"\n' > "$out/alone.c"
{   # names that other headers own: all of them come first
    for h in elf.h sys/ptrace.h sys/param.h sys/mman.h sys/socket.h sys/wait.h sys/uio.h netinet/in.h netinet/tcp.h net/if.h \
             termios.h signal.h pthread.h setjmp.h complex.h tgmath.h curses.h; do
        case $h in complex.h|tgmath.h) echo "#ifndef __cplusplus";; esac
        printf '#if defined(__has_include)\n#if __has_include(<%s>)\n#include <%s>\n#endif\n#endif\n' "$h" "$h"
        case $h in complex.h|tgmath.h) echo "#endif";; esac
    done
    echo '#define PT_IMPLEMENTATION'
    echo '#include "pt.h"'
    echo '#include "pt.h"'
} > "$out/crowded.c"
cp "$out/alone.c" "$out/alone.cc"
cp "$out/crowded.c" "$out/crowded.cc"

matrix() {                            # COMPILER LANGUAGE SUFFIX
    compiler=$1 language=$2 suffix=$3 log=$out/$1$2.log object=$out/$1$2.o
    if ! have "$compiler"; then skip "$compiler $language" "no $compiler"; return; fi
    strict=
    case $language in *c99) strict=-Wstrict-prototypes;; esac
    all='-DPT_STATIC -DPT_NO_THREADS -DPT_NO_STDIO -DPT_NO_SIMD'
    for switches in '' -DPT_STATIC -DPT_NO_THREADS -DPT_NO_STDIO -DPT_NO_SIMD "$all"; do
        case $language$switches in *20*) how='-fsyntax-only -o';; *11 | *99 | *"$all") how='-O2 -c -o';; *) how='-O0 -c -o';; esac
        # shellcheck disable=SC2086   # flags are several words
        step "$compiler $language ${how% -o} $switches" $compiler $language $warnings $strict $switches -I. $how "$object" \
            "$out/alone.$suffix"
    done
    # shellcheck disable=SC2086
    step "$compiler $language, after other headers" $compiler $language -Wall -Wextra -Werror -D_GNU_SOURCE -I. \
        -c "$out/crowded.$suffix" -o "$object"
}
{ matrix gcc   -std=c99 c; matrix g++     -std=c++11 cc; matrix clang++ -std=c++20 cc; } &      # two at a time
{ matrix clang -std=c99 c; matrix clang++ -std=c++11 cc; matrix g++     -std=c++20 cc; }
wait

# ---- what an object needs from outside: memory, strings, and the square root and such
only_needs() {                        # OBJECT ALLOWED: a pattern for whole names
    nm -u "$1" | awk '{ print $NF }' | grep -vE "^(_GLOBAL_OFFSET_TABLE_|__stack_chk_fail|$2)\$" > "$out/needs"
    [ ! -s "$out/needs" ] || { echo "needs also: $(tr '\n' ' ' < "$out/needs")"; return 1; }
}
bare='mem(cpy|set|move|cmp|chr)|bcmp|str[a-z]+|sqrtf?|floorf?|fabsf?|malloc|free'      # bcmp: clang's memcmp
for compiler in gcc clang; do
    have $compiler || continue
    $compiler -O2 -DPT_NO_STDIO -DPT_NO_THREADS -I. -c "$out/alone.c" -o "$out/bare.o"
    step "$compiler: with PT_NO_STDIO and PT_NO_THREADS only memory is needed" only_needs "$out/bare.o" "$bare"
done

# ---- names: nothing defined or published outside pt_ and pti_
only_defines() { ! nm -g --defined-only "$1" | awk '{ print $NF }' | grep -vE '^pti?_'; }
only_macros() {                       # the macros that an include of pt.h adds, the system's headers aside
    printf '#include <float.h>\n#include <math.h>\n#include <stdarg.h>\n#include <stdlib.h>\n#include <string.h>\n#include <stdio.h>\n#include <pthread.h>\n#include <sys/time.h>\n#include <unistd.h>\n#include <stdint.h>\n#include <stddef.h>\n' > "$out/before.c"
    if [ "$(uname -m)" = x86_64 ]; then printf '#include <immintrin.h>\n#include <cpuid.h>\n' >> "$out/before.c"; fi
    cp "$out/before.c" "$out/after.c"
    cat "$out/alone.c" >> "$out/after.c"
    gcc -I. -dM -E "$out/before.c" | sort > "$out/before.txt"
    gcc -I. -dM -E "$out/after.c" | sort > "$out/after.txt"
    ! comm -13 "$out/before.txt" "$out/after.txt" | grep -vE '^#define PTI?_'
}
constant_data() {                     # no mutable globals: nothing in .data or .bss (-fno-pic: else constant pointers are there)
    ! nm "$1" | grep -E ' [dDbBcC] '
}
if have gcc; then
    gcc -O2 -I. -c "$out/alone.c" -o "$out/names.o"
    gcc -O1 -fno-pie -fno-pic -I. -c "$out/alone.c" -o "$out/data.o"
    step 'symbols begin with pt_' only_defines "$out/names.o"
    step 'macros begin with PT_ or PTI_' only_macros
    step 'no mutable globals' constant_data "$out/data.o"
fi
refuses() { ! "$@" > "$out/refused" 2>&1 && grep -q 'PT_ALLOW_FAST_MATH' "$out/refused"; }
for compiler in gcc clang; do
    have $compiler || continue
    step "$compiler: -ffast-math is refused in words" refuses $compiler -ffast-math -I. -c "$out/alone.c" -o "$out/fast.o"
done
step 'C++: two files share one implementation' sh -c "
    printf '#include \"pt.h\"\nint main() { pt_scene *s = pt_scene_create(0); pt_scene_destroy(s); return s == 0; }\n' > $out/user.cc &&
    g++ -std=c++11 -I. $out/user.cc $out/names.o -o $out/user -lm -lpthread && $out/user"

# ---- the examples: no warnings; and each draws its picture, with one sample a pixel to be quick
draws() {                             # SOURCE PROGRAM: the picture must be there and end a clean run
    sed 's/\.spp = [0-9]*/.spp = 1/; s/total == [0-9]*/total == 2/; s|"../pt.h"|"pt.h"|' "$1" > "$2.c" &&
        gcc -std=c99 -O1 -I. "$2.c" -o "$2" -lm -lpthread && rm -f "$2.png" && "$2" "$2.png" && test -s "$2.png"
}
check_examples() {
    log=$out/examples.log
    for example in examples/*.c; do
        case $example in */stb_*) [ -f /usr/include/stb/stb_image.h ] || { skip "$example" "no stb_image.h"; continue; };; esac
        for compiler in gcc clang; do
            if have $compiler; then
                step "$compiler: $example" $compiler -std=c99 -Wall -Wextra -Wpedantic -Werror -fsyntax-only "$example"
            fi
        done
        case $example in */[0-9]*) step "draws: $example" draws "$example" "$out/$(basename "$example" .c)";; esac
    done
}
check_examples &                      # beside what follows

# ---- the tests under sanitizers
sanitized() {                         # NAME FLAGS FILE...
    kind=$1 flags=$2
    shift 2
    mkdir -p "$out/$kind"
    # shellcheck disable=SC2086
    printf '%s\n' "$@" | sed 's|tests/\(.*\)\.c|\1|' | xargs -P 2 -I{} clang -gline-tables-only -O1 $flags -fno-omit-frame-pointer -I. -c tests/{}.c -o "$out/$kind/{}.o" &&
        clang $flags "$out/$kind"/test_*.o -o "$out/$kind/run" -lm -lpthread || return 1
    "$out/$kind/run" --list | grep -v '^ ' > "$out/$kind/chapters"
    awk 'NR % 2' "$out/$kind/chapters" | xargs "$out/$kind/run" & half=$!             # two at a time
    awk 'NR % 2 == 0' "$out/$kind/chapters" | xargs "$out/$kind/run"; other=$?
    wait $half && [ $other = 0 ]
}
if have clang; then
    rm -rf "$out/asan" "$out/tsan"
    { log=$out/asan.log
      step 'tests under AddressSanitizer and UndefinedBehaviorSanitizer' sanitized asan '-fsanitize=address,undefined -fno-sanitize-recover=all' tests/test_*.c; } &
    { log=$out/tsan.log               # a race needs threads, and only these tests start some
      step 'tests under ThreadSanitizer' sanitized tsan '-fsanitize=thread -DTEST_THREADS' \
          tests/test_main.c tests/test_bvh.c tests/test_scene.c tests/test_render.c; }
    wait
else
    skip 'tests under sanitizers' 'no clang'
fi
wait

sed 's/^/failed: /' "$out/failed"
echo "check: $(wc -l < "$out/failed") failed, $(wc -l < "$out/skipped") skipped"
[ ! -s "$out/failed" ]
