#!/usr/bin/env bash
# take_libraries.sh PROGRAM FOLDER LICENCES: copies into FOLDER every shared library that a program or a module needs, but those of the
# C library, which the system's loader belongs to, and into LICENCES the licences of their packages. PROGRAM and libraries are
# stripped; libraries lose their RPATHs, so that PROGRAM's, which is to be set, is theirs.
set -euo pipefail
[ $# = 3 ] || { echo "take_libraries.sh: expected PROGRAM FOLDER LICENCES" >&2; exit 2; }
mkdir -p "$2" "$3"
ldd "$1" | awk '$2 == "=>" && $3 ~ /^\// { print $3 }' | grep -vE '/(libc|libm|libdl|librt|libpthread|libresolv|ld-[^/]*)\.so' |
  while read -r library; do
    cp -L "$library" "$2/"
    package=$(dpkg -S "*/$(basename "$(realpath "$library")")" | head -1 | cut -d: -f1)
    [ ! -f "/usr/share/doc/$package/copyright" ] || cp "/usr/share/doc/$package/copyright" "$3/$package"
  done
libraries=$(find "$2" -maxdepth 1 -type f)
strip --strip-unneeded "$1" $libraries
for library in $libraries; do patchelf --remove-rpath "$library"; done
