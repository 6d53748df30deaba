#!/usr/bin/env bash
# bundle.sh -o OUT [--build DIR]: gpvc-texrecon with every shared library that it needs, as OUT/ and OUT.tar.xz
#
# OUT runs from wherever it lies, on any Linux whose C library is as new as the one here or newer (glibc 2.36 of Debian 12; Ubuntu
# 24.04 has 2.39), with no package installed: no OpenImageIO, EGL or Mesa. It is for the processor family of this machine, and for
# each of that family: faster instructions are chosen at run time.
#   OUT/bin/gpvc-texrecon   starts it
#   OUT/bin/texrecon        the same, under the name that others call
#   OUT/lib/gpvc/           libraries, with their licences in OUT/share/gpvc/licences
# JPEG, PNG and TIFF are read, other image formats are not: they would take OpenImageIO and 200 MB of libraries along.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build/bundle
out=
usage() { echo "bundle.sh: $1; see the head of $0" >&2; exit 2; }
while [ $# -gt 0 ]; do
  case $1 in
    -o | --build)
      [ $# -ge 2 ] || usage "$1 takes a value"
      if [ "$1" = -o ]; then out=$2; else build=$2; fi
      shift ;;
    -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) usage "there is no option '$1'" ;;
  esac
  shift
done
[ -n "$out" ] || usage "-o OUT is missing"
[ ! -e "$out" ] || [ -d "$out/lib/gpvc" ] || { echo "bundle.sh: $out exists and is no bundle; give another folder" >&2; exit 1; }

"$root/app/setup/install_packages.sh" bundle
if [ ! -f "$build/build.ninja" ]; then
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON >/dev/null
fi
cmake --build "$build" --target gpvc-texrecon
program=$build/app/gpvc-texrecon

rm -rf "$out" "$out.tar.xz"
mkdir -p "$out/bin" "$out/lib/gpvc" "$out/share/gpvc/licences"
cp "$program" "$out/bin/gpvc-texrecon"
ln -s gpvc-texrecon "$out/bin/texrecon"
"$root/app/setup/take_libraries.sh" "$out/bin/gpvc-texrecon" "$out/lib/gpvc" "$out/share/gpvc/licences"
# DT_RPATH, which is asked before LD_LIBRARY_PATH and for libraries of libraries, too: what lies there belongs together.
patchelf --force-rpath --set-rpath '$ORIGIN/../lib/gpvc' "$out/bin/gpvc-texrecon"

# What it still takes from the system, and how new that has to be.
outside=$(ldd "$out/bin/gpvc-texrecon" | awk '$2 == "=>" { print $3 }' | grep -v "^$(realpath "$out")/" | xargs -n 1 basename | sort | tr '\n' ' ')
newest() { objdump -T "$out/bin/gpvc-texrecon" "$out"/lib/gpvc/* 2>/dev/null | grep -oE "$1_[0-9.]+" | sort -Vu | tail -1; }
"$out/bin/gpvc-texrecon" --version
(cd "$(dirname "$out")" && tar -cJf "$(basename "$out").tar.xz" "$(basename "$out")")
echo "$out: $(du -sm --apparent-size "$out" | cut -f1) MB in $(ls "$out/lib/gpvc" | wc -l) libraries, $out.tar.xz: $(du -m "$out.tar.xz" | cut -f1) MB"
echo "of the system: $outside($(newest GLIBC) or newer); in the bundle: libstdc++ up to $(newest GLIBCXX)"
