#!/bin/sh
# Builds and runs bench_mesh.cc with those of the other readers that are installed.
# usage: bench_mesh.sh OUT [mesh.obj]
out=$1 mesh=${2:-../shared/data/meshes/stanford-bunny.obj}
cxx=${CXX:-c++}
command -v "$cxx" > /dev/null || { echo "mesh reading skipped: no $cxx"; exit 0; }
mkdir -p "$out" || exit 1
flags='' libraries=''
has() { echo "#include <$1>" | "$cxx" -E -x c++ - > /dev/null 2>&1; }
if has tiny_obj_loader.h; then flags="$flags -DBENCH_TINYOBJ"; fi
if has assimp/cimport.h; then flags="$flags -DBENCH_ASSIMP" libraries=-lassimp; fi
# shellcheck disable=SC2086   # flags are several words
"$cxx" -O2 $flags tests/bench/bench_mesh.cc -o "$out/bench_mesh" $libraries -lm -lpthread && "$out/bench_mesh" "$out" "$mesh"
