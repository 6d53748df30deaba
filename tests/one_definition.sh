#!/usr/bin/env bash
# Each type that the linker sees has one definition: two of one name, in sources that never meet in a compiler, would be mixed up
# without a word. Looks at names, in seconds; -DGPVC_LTO=ON has GCC compare what the types are made of (-Wodr), in minutes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
twice=$(git ls-files '*.h' '*.cpp' | ctags -L - -f - --languages=C++ --langmap=C++:+.h --c++-kinds=csug --fields=sKn |
  awk -F'\t' '
    /__anon/ { next }  # of one source
    {
      scope = line = ""
      for (i = 4; i <= NF; ++i) {
        if ($i ~ /^(namespace|class|struct|union):/) { scope = $i; sub(/^[a-z]+:/, "", scope) }
        if ($i ~ /^line:/) line = substr($i, 6)
      }
      if (scope == "") next  # all of ours are in a namespace; the rest are variables of types of C
      name = scope "::" $1
      if (name in first) print first[name] " and " $2 ":" line ": " name
      else first[name] = $2 ":" line
    }')
if [ -n "$twice" ]; then
  echo "one_definition.sh: defined twice:" >&2
  echo "$twice" >&2
  exit 1
fi
