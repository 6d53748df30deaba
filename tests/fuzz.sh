#!/usr/bin/env bash
# fuzz.sh [SECONDS [NAME...]]: runs each libFuzzer target for SECONDS (default 10), as many at once as there are processors,
# from the seeds in tests/fuzz/corpus and those that it makes itself. Inputs that reach new code are kept in build/fuzz/found/NAME and
# used again by the next run; a finding is left in build/fuzz/artifacts/NAME and ends the run with its report.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
export seconds=${1:-10}
shift || true
"$root/app/setup/install_packages.sh" clang

export build=$root/build/fuzz corpus=$root/tests/fuzz/corpus
. "$root/tests/support/ccache.sh"
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Debug "-DCMAKE_CXX_FLAGS_DEBUG=-O1 -g1" \
  -DGPVC_FUZZ=ON -DCMAKE_UNITY_BUILD=ON -DGPVC_PRECOMPILED=ON "$with_ccache" >/dev/null
cmake --build "$build" --target fuzz

run_one() {
  local name=$1 log=$build/log/$1 left=$seconds round mask=0
  mkdir -p "$build/found/$name" "$build/artifacts/$name" "$build/log" "$build/seeds/$name"
  : >"$log"
  local from=("$build/found/$name" "$build/seeds/$name")
  [ ! -d "$corpus/$name" ] || from+=("$corpus/$name")
  GPVC_FUZZ_TARGET=$name GPVC_FUZZ_SEEDS=$build/seeds/$name GPVC_FUZZ_CORPUS=$corpus ASAN_OPTIONS=detect_leaks=0 "$build/fuzz/fuzz"
  # What commands print goes nowhere, and a finding's report where it belongs.
  case $name in inspect | job_json) mask=3 ;; esac
  # A new process every ten minutes: OpenImageIO keeps each distinct string it meets (ustring), 2 KB an input, which
  # would reach the limit within half an hour of images and tell nothing of any one of them.
  for (( ; left > 0; left -= round)); do
    round=$((left < 600 ? left : 600))
    # 256 MB in one piece for inputs of at most 64 KiB: a count in a header was believed.
    if ! ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=0 UBSAN_OPTIONS=print_stacktrace=1 \
      GPVC_FUZZ_TARGET=$name "$build/fuzz/fuzz" -max_total_time="$round" -timeout=10 -rss_limit_mb=3000 -malloc_limit_mb=256 -max_len=65536 \
      -close_fd_mask=$mask -print_final_stats=1 -artifact_prefix="$build/artifacts/$name/" "${from[@]}" >>"$log" 2>&1; then
      tail -n 60 "$log" >&2
      echo "fuzz.sh: $name: a finding, kept in $build/artifacts/$name" >&2
      return 1
    fi
  done
  awk -v name="$name" '/stat::number_of_executed_units/ { units += $2 } / cov: / { for (i = 1; i < NF; ++i) if ($i == "cov:") cov = $(i + 1) }
    END { printf "%-16s %9d inputs, %5d edges, no finding\n", name, units, cov }' "$log"
}
export -f run_one
names=("$@")
if [ ${#names[@]} = 0 ]; then
  for source in "$root"/tests/fuzz/fuzz_*.cpp; do
    name=$(basename "$source" .cpp)
    names+=("${name#fuzz_}")
  done
fi
printf '%s\n' "${names[@]}" | xargs -P "$(nproc)" -I{} bash -c 'run_one {}'
