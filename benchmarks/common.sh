# What the scripts of this folder share; they source it.
script=$(basename "$0")
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

fail() { echo "$script: $1" >&2; exit "${2:-1}"; }
usage() { fail "$1; see $script --help" 2; }

# read_arguments OPTIONS ARGUMENT...: OPTIONS are names of options that take a value, each once, as one word: "hold-out gpvc o". "--hold-out 8"
# sets `hold_out`, "-o DIR" sets `o`; what is no option is in `places`. --help prints the head of the script.
read_arguments() {
  local known=" $1 " name
  shift
  places=()
  while [ $# -gt 0 ]; do
    case $1 in
      -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; exit 0 ;;
      -?*)
        name=${1#-}
        name=${name#-}
        [[ $known == *" $name "* ]] || usage "there is no option '$1'"
        [ $# -ge 2 ] || usage "$1 takes a value"
        printf -v "${name//-/_}" %s "$2"
        shift ;;
      *) places+=("$1") ;;
    esac
    shift
  done
}

# find_gpvc: the program that --gpvc names, or build/release/app/gpvc, which it builds, into `gpvc`.
find_gpvc() {
  if [ -n "$gpvc" ]; then
    [ -x "$gpvc" ] || fail "$gpvc is not a program"
    gpvc=$(realpath "$gpvc")
    return
  fi
  local build=$root/build/release
  "$root/app/setup/install_packages.sh" build
  [ -f "$build/build.ninja" ] ||
    cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release >/dev/null
  cmake --build "$build" --target gpvc
  gpvc=$build/app/gpvc
}

# figure FILE NAME: the first number of that name in a JSON file.
figure() { sed -n "s/^ *\"$2\": \([-+0-9.e]*\),*$/\1/p" "$1" | head -1; }

# said_last FILE: its last line that is not blank, without what a progress display overwrote.
said_last() { tr '\r' '\n' <"$1" | sed 's/^[[:space:]]*//; s/[[:space:]]*$//; /^$/d' | tail -1; }
