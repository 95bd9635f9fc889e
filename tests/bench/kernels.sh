#!/bin/sh
# Builds kernels.c with pt.h under two sets of flags and, where it is installed, Embree 3; runs it with the options given.
# usage: kernels.sh OUT [options of kernels.c]
case ${1:--} in
-*) echo 'usage: kernels.sh OUT [options of kernels.c]    (OUT: where to put what it makes; then --help tells the options)' >&2; exit 2;;
esac
out=$1
shift
cc=${CC:-cc}
mkdir -p "$out/kernels" || exit 1
here=$(dirname "$0")
objects='' list='' libraries=''
compile() {                           # SOURCE NAME FLAGS
    source=$1 name=$2
    shift 2
    $cc "$@" -c "$here/$source" -o "$out/kernels/$name.o" || exit 1
    objects="$objects $out/kernels/$name.o"
}
compile kernels_pt.c pt -O2 -DKERNELS_NAME=pt
compile kernels_pt.c pt_native -O3 -march=native -DKERNELS_NAME=pt_native
compile kernels_pt.c pt_best -O2 -DKERNELS_NAME=pt_best -DKERNELS_QUALITY=PT_QUALITY_BEST
list='X(pt) X(pt_native) X(pt_best)'
if [ -n "$PT_OTHER" ]; then           # another pt.h, to compare with
    compile kernels_pt.c pt_other -O2 -DKERNELS_NAME=pt_other "-DPT_HEADER=\"$PT_OTHER\""
    list="$list X(pt_other)"
fi
if echo '#include <embree3/rtcore.h>' | $cc -E - > /dev/null 2>&1; then
    compile kernels_embree.c embree -O2
    list="$list X(embree) X(embree_robust) X(embree_best)" libraries=-lembree3
fi
compile kernels_scenes.c scenes -O2
compile kernels.c main -O2 "-DKERNELS_LIBRARIES(X)=$list"
# shellcheck disable=SC2086   # several words
$cc $objects -o "$out/kernels/kernels" $libraries -lm -lpthread && "$out/kernels/kernels" "$@"
