#!/usr/bin/env bash
# run.sh [--without-benchmarks | --sanitize [--below-app] | --threads] [CTEST ARGUMENTS]: installs what is missing, builds, runs
# every test through CTest.
#   --without-benchmarks   which take a fifth of the time to compile, and their two tests
#   --sanitize             Debug build by Clang under the address and undefined behaviour sanitizers, into build/sanitize
#   --sanitize --below-app the same without app/ and its tests (the Release run has found the device)
#   --threads              Debug build by Clang under the thread sanitizer, into build/threads, of what
#                          tests/threads/programs.cmake names; takes many minutes, so not part of .ci/run
# Tests of OpenGL run on whatever EGL device there is (Mesa's llvmpipe without a GPU); here they must run, not skip.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

build=$root/build/release
packages=(test)
targets=(all)
benchmarks=ON
if [ "${1:-}" = --without-benchmarks ]; then
  shift
  benchmarks=OFF
fi
options=(-DCMAKE_BUILD_TYPE=Release -DGPVC_SANITIZE=OFF -DGPVC_BENCHMARKS=$benchmarks)
below_app=OFF
if [ "${1:-}" = --sanitize ]; then
  shift
  if [ "${1:-}" = --below-app ]; then
    shift
    below_app=ON
  fi
  build=$root/build/sanitize
  packages=(test clang)
  # The second compiler here, so that both must find the code free of warnings.
  options=(-DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Debug -DGPVC_SANITIZE=ON -DGPVC_BENCHMARKS=OFF -DGPVC_BELOW_APP=$below_app
    "-DCMAKE_CXX_FLAGS_DEBUG=-O1 -g1")
fi
if [ "${1:-}" = --threads ]; then
  shift
  build=$root/build/threads
  packages=(test clang)
  targets=(gpvc threads_tests)
  options=(-DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Debug -DGPVC_TSAN=ON -DGPVC_BENCHMARKS=OFF "-DCMAKE_CXX_FLAGS_DEBUG=-O1 -g1")
  set -- -L threads "$@"
fi

for group in "${packages[@]}"; do "$root/app/setup/install_packages.sh" "$group"; done

# Khronos' glTF validator, three.js, esbuild and the viewers of 3D Tiles come from the npm registry; everything else from Debian.
node_modules=$root/build/node/node_modules
for package in gltf-validator three esbuild 3d-tiles-renderer cesium; do
  if [ ! -d "$node_modules/$package" ]; then
    mkdir -p "$root/build/node"
    npm install --silent --no-audit --no-fund --prefix "$root/build/node" \
      gltf-validator@2.0.0-dev.3.10 three@0.170.0 esbuild@0.24.2 3d-tiles-renderer@0.5.3 cesium@1.145.0
    break
  fi
done

. "$root/tests/support/ccache.sh"
cmake -S "$root" -B "$build" -G Ninja "${options[@]}" -DGPVC_TESTS=ON -DGPVC_WERROR=ON -DCMAKE_UNITY_BUILD=ON -DGPVC_PRECOMPILED=ON \
  "$with_ccache" "-DGPVC_NODE_MODULES=$node_modules" >/dev/null
cmake --build "$build" --target "${targets[@]}"

# Drivers keep memory until exit: leaks are looked for by running under valgrind by hand, not here.
export ASAN_OPTIONS=detect_leaks=0:strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1
# What libraries do under locks that the sanitizer does not see is not judged.
export TSAN_OPTIONS=ignore_noninstrumented_modules=1:suppressions=$root/tests/threads/suppressions.txt
cd "$build"
if [ $below_app = OFF ] && ! app/gpvc --device list; then
  echo "run.sh: without an EGL device every test of OpenGL would be skipped, and a skipped test is not passed" >&2
  exit 1
fi
# Results are flushed to disk before they are published, and tests write thousands of them: in memory, where there is enough,
# that takes no time.
if [ -z "${TMPDIR:-}" ] && [ "$(df --output=avail /dev/shm 2>/dev/null | tail -n 1)" -ge $((8 << 20)) ] 2>/dev/null; then
  TMPDIR=$(mktemp -d /dev/shm/gpvc-tests-XXXXXX)
  export TMPDIR
  trap 'rm -rf "$TMPDIR"' EXIT
fi
ctest --output-on-failure --no-tests=error --parallel "$(nproc)" "$@"
