#!/usr/bin/env bash
# install_packages.sh [build|view|test|clang|bundle|wheel]: installs the Debian packages of packages.txt that are missing, and nothing else.
# Quiet and quick when all are there.
set -euo pipefail
list=$(dirname "$0")/packages.txt
wanted=${1:-build}
case $wanted in
  build) sections=build ;;
  view) sections='build|view' ;;
  test) sections='build|test' ;;
  clang) sections='build|clang' ;;
  bundle) sections='build|bundle' ;;
  wheel) sections='build|wheel' ;;
  *) echo "install_packages.sh: expected build, view, test, clang, bundle or wheel, got '$wanted'" >&2; exit 2 ;;
esac

packages=$(awk -v sections="^($sections)\$" '
  /^#/ || /^$/ { next }
  /^\[/ { gsub(/[\[\]]/, ""); on = ($0 ~ sections); next }
  on' "$list")

# A tool that is there under another package name (a newer node, say) is as good.
have() {
  case $1 in
    nodejs) command -v node >/dev/null && return 0 ;;
    npm | cmake | g++ | clang-format | clang-tidy) command -v "$1" >/dev/null && return 0 ;;
    ninja-build) command -v ninja >/dev/null && return 0 ;;
  esac
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

missing=()
for package in $packages; do
  have "$package" || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

if ! command -v apt-get >/dev/null; then
  echo "install_packages.sh: this script knows Debian's apt-get only; please install: ${missing[*]}" >&2
  exit 1
fi
as_root=()
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "install_packages.sh: run as root (or install sudo) to install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "Installing ${#missing[@]} packages: ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { "${as_root[@]}" apt-get update -q &&
       "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
  cat "$log" >&2
  echo "install_packages.sh: apt-get failed; its output is above" >&2
  exit 1
fi
