#!/usr/bin/env bash
# tidy.sh [FILE...]: clang-tidy on these sources, each compiled by itself, and for a header on one source that includes
# it; without arguments on all sources.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
cmake -S . -B build/alone -G Ninja -DCMAKE_BUILD_TYPE=Release -DGPVC_TESTS=ON -DGPVC_BENCHMARKS=ON -DGPVC_WERROR=ON -DCMAKE_UNITY_BUILD=OFF -DGPVC_PRECOMPILED=OFF >/dev/null

folders='(io|visibility|labeling|atlas|app|tests|benchmarks)/'
sources=()
if [ $# = 0 ]; then
  sources=("$root/$folders")
fi
for file in "$@"; do
  if [[ ! $file =~ ^$folders ]] || [ ! -f "$file" ]; then continue; fi
  case $file in
    *.cpp) ;;
    *.h) file=$(git grep -lF "#include \"$file\"" -- '*.cpp' | sed -n 1p || true) ;;
    *) continue ;;
  esac
  if [ -n "$file" ]; then sources+=("^$root/$file\$"); fi
done
if [ ${#sources[@]} -gt 0 ]; then
  run-clang-tidy -quiet -p build/alone -extra-arg=-Wno-unknown-warning-option "${sources[@]}" 2>/dev/null
fi
