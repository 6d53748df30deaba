#!/usr/bin/env bash
# changed.sh: prints the files that differ from the last commit known to be good, one a line: where this branch left main,
# or on main the commit that .ci/run passed on last. Exit status 1 where there is no such commit, as in a shallow clone.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
head=$(git rev-parse HEAD)
base=
for branch in origin/main main; do
  if fork=$(git merge-base "$branch" HEAD 2>/dev/null) && [ "$fork" != "$head" ]; then
    base=$fork
    break
  fi
done
if [ -z "$base" ] && [ -f build/ci_passed ]; then
  passed=$(cat build/ci_passed)
  if git merge-base --is-ancestor "$passed" HEAD 2>/dev/null; then base=$passed; fi
fi
[ -n "$base" ] || exit 1
git diff --name-only "$base"
git ls-files --others --exclude-standard
