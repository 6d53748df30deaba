#!/usr/bin/env bash
# reproduce_paper.sh [--quick] [DIR]   from nothing to DIR/index.html (DIR: out/paper, out/paper-quick): tables 1 to 9 of
#                                      Huang, Zhu, Jiang 2018 with the paper's numbers beside ours, figures 15, 17, 18 and
#                                      20 to 26 as pictures, and agreement with the exact oracle over epsilon
# reproduce_paper.sh --page DIR        the page alone, of what DIR holds
#
# Installs the Debian packages that are missing, builds Release into build/release (GPVC_BUILD: another folder, used as
# it is), makes the synthetic scenes, compares the modes on them and on the real scenes of DATA (default: shared/data
# beside the repository) where there are any. --quick: smaller scenes and fewer modes, some minutes on two cores.
# What DIR holds already is kept: a run that was stopped goes on where it was; remove a folder to make it again. A DIR
# that another version of the program made, or that is of the other kind, is refused.
set -euo pipefail
export LC_ALL=C
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
quick=no
page_alone=no
out=
for word in "$@"; do
  case $word in
    --quick) quick=yes ;;
    --page) page_alone=yes ;;
    -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "reproduce_paper.sh: there is no option '$word'; usage: reproduce_paper.sh [--quick | --page] [DIR]" >&2; exit 2 ;;
    *) out=$word ;;
  esac
done
if [ -z "$out" ]; then
  out=$root/out/paper
  [ $quick = yes ] && out=$root/out/paper-quick
fi
data=${DATA:-$root/../shared/data}
failures=()
missing=()

# --- the page -------------------------------------------------------------------------------------------------------

data_of() { printf '<script type="text/plain" data-name="%s">\n%s\n</script>\n' "$1" "$2"; }  # no data has "</script"
# facts: a line "NAME<tab>TEXT" for each thing that no other file of DIR says.
facts() {
  printf 'made_by\t%s\n' "$(cat "$out/made_by.txt" 2>/dev/null)"
  [ -f "$out/facts.txt" ] && cat "$out/facts.txt"
  [ ${#missing[@]} -gt 0 ] && printf 'missing\tThe real scenes %s are not at hand.\n' "${missing[*]}"
  [ ${#failures[@]} -gt 0 ] && printf 'failed\tFailed, see what was printed: %s.\n' "${failures[*]}"
  if [ -d "$out/figure_17" ]; then
    printf 'offset\t%s\n' "$(head -1 "$out/figure_17/offset.txt")"
    printf 'ncc\t%s\n' "$(awk '$1 == "mean" { printf "%s ", $5 }' "$out/figure_17/default.txt" "$out/figure_17/shader.txt")"
    printf 'figure_17\t%s\n' "$(cd "$out/figure_17/shader" && ls ./*.png | head -1)"
  fi
  [ -f "$out/summary/summary.md" ] && printf 'summary\t%s\n' "$(sed -n '/^By /p' "$out/summary/summary.md" | tr '\n' ' ')"
  return 0
}
write_page() {
  local file name
  {
    data_of facts "$(facts)"
    for file in "$out"/tables_*/*.csv; do [ -f "$file" ] && data_of "$(basename "$file" .csv)" "$(cat "$file")"; done
    for name in city slits terrain brighton sceaux; do
      file=$out/compare_$name/report.html
      [ -f "$file" ] && data_of "compare_$name" "$(sed -n 's/^<script id="data" type="application\/json">\(.*\)<\/script>$/\1/p' "$file")"
    done
    true
  } >"$out/data.unfinished"
  awk -v css="$root/app/compare/report.css" -v js="$root/app/compare/report.js" -v data="$out/data.unfinished" '
    function all_of(file, line) { while ((getline line < file) > 0) print line }
    $0 == "/*report.css*/" { all_of(css); next }
    $0 == "/*report.js*/" { all_of(js); next }
    $0 == "<!--data-->" { all_of(data); next }
    { print }' "$root/benchmarks/paper.html" >"$out/index.html.unfinished"
  rm "$out/data.unfinished"
  mv "$out/index.html.unfinished" "$out/index.html"
  echo "$out/index.html"
}
if [ $page_alone = yes ]; then
  out=$(cd "$out" && pwd)
  write_page
  exit
fi

# --- what is run ----------------------------------------------------------------------------------------------------

if [ -n "${GPVC_BUILD:-}" ]; then
  build=$GPVC_BUILD
else
  build=$root/build/release
  "$root/app/setup/install_packages.sh" build
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DGPVC_BENCHMARKS=ON >/dev/null
  cmake --build "$build" --target gpvc accuracy_benchmark efficiency_benchmark
fi
gpvc=$build/app/gpvc
mkdir -p "$out"
out=$(cd "$out" && pwd)
made_by="$("$gpvc" --version), quick: $quick"
earlier=$(cat "$out/made_by.txt" 2>/dev/null || { [ -z "$(ls "$out")" ] || echo unknown; })
if [ -n "$earlier" ] && [ "$earlier" != "$made_by" ]; then
  echo "reproduce_paper.sh: $out was made by '$earlier', this is '$made_by'; give another folder, or remove that one" >&2
  exit 1
fi
echo "$made_by" >"$out/made_by.txt"

papers=1e-5,1e-4,1e-3,1e-2  # the paper's epsilons
modes=none,shadow-map:spc,shadow-map:apc,ray:sparse,ray:dense,gpvc:uncorrected,gpvc,gpvc:ves
timed=gpvc/paper/cpu,gpvc:dense/paper/cpu,gpvc:ves/paper/cpu
for family in shadow-map:spc shadow-map:apc ray:sparse ray:dense; do
  for epsilon in ${papers//,/ }; do
    timed+=,$family:$epsilon
    [ $quick = no ] && modes+=,$family:$epsilon  # beside those that suit the scene
  done
done
if [ $quick = yes ]; then
  city=(--faces 20000 --photos 10 --photo-size 720x480)
  terrain=(--gap 0.01 --faces 20000 --photos 10 --photo-size 720x480) slits=(--photos 10 --photo-size 720x480)
  compare=(--eps "$papers" --oracle-views 2 --score-views 4 --crops 3)
  accuracy=(--quick) efficiency=(--views 2)
else
  city=(--faces 324000 --photos 40 --photo-size 3000x2000)
  terrain=(--gap 0.01) slits=()
  compare=(--oracle-views 3 --crops 3)
  accuracy=() efficiency=()
fi

# once NAME COMMAND...: runs it unless DIR/NAME is there; DIR/NAME.partial is renamed when it is complete.
once() {
  local name=$1
  shift
  [ -e "$out/$name" ] && return 0
  echo "== $name"
  rm -rf "$out/$name.partial"
  if "$@" "$out/$name.partial"; then mv "$out/$name.partial" "$out/$name"; else
    echo "reproduce_paper.sh: $name failed; the rest goes on" >&2
    failures+=("$name")
    return 0
  fi
}

accuracy_tables() { mkdir -p "$1" && "$build/benchmarks/accuracy" -o "$1" "${accuracy[@]}" >"$1/accuracy.txt"; }
efficiency_tables() { mkdir -p "$1" && "$build/benchmarks/efficiency" -o "$1" --modes "$timed" "${efficiency[@]}" >"$1/efficiency.md"; }
synth() { local kind=$1 folder=${!#}; set -- "${@:2:$#-2}"; "$gpvc" synth "$kind" -o "$folder" "$@" >/dev/null; }
# A mode that failed is in the report as such.
compared() {
  local scene=$1 mesh=$2 folder=${!#}
  set -- "${@:3:$#-3}"
  "$gpvc" compare "$scene" "$mesh" -o "$folder" "$@" >/dev/null || { [ -f "$folder/report.json" ] && failures+=("a mode on $scene"); }
}

once tables_1_to_6 accuracy_tables
once tables_7_to_9 efficiency_tables
once scenes/city synth city "${city[@]}"
once scenes/terrain synth terrain "${terrain[@]}"
once scenes/slits synth slits "${slits[@]}"

reports=()
: >"$out/facts.txt"
[ $quick = yes ] && printf 'quick\tsmaller scenes and fewer epsilons than without --quick: the figures are rougher\n' >>"$out/facts.txt"
# modes_on NAME FOLDER OPTIONS...: compares the modes on the scene, which is left out where it is not there.
modes_on() {
  local name=$1 folder=$2
  shift 2
  once "compare_$name" compared "$folder/colmap" "$folder/mesh.ply" --modes "$modes" --hold-out 5 "${compare[@]}" "$@"
  printf 'non_manifold_%s\t%s\n' "$name" "$("$gpvc" inspect "$folder/colmap" "$folder/mesh.ply" 2>/dev/null |
    sed -n 's/.*, \([0-9 ]*\) non-manifold faces.*/\1/p')" >>"$out/facts.txt"
}
for name in city slits terrain; do
  [ -d "$out/scenes/$name" ] || continue
  modes_on "$name" "$out/scenes/$name"
  [ -f "$out/compare_$name/report.json" ] && reports+=("$out/compare_$name/report.json")
done
reduced=()
[ $quick = yes ] && reduced=(--downscale 4)
for name in brighton sceaux; do
  if [ -f "$data/$name/mesh.ply" ]; then modes_on "$name" "$data/$name" "${reduced[@]}"; else missing+=("$name"); fi
done
[ ${#reports[@]} -gt 0 ] && once summary "$gpvc" compare --summarize "${reports[@]}" -o

# Figure 17: cameras whose principal point is put into the middle.
# The steps hang together by &&, as `once` asks for the outcome and so switches `set -e` off.
figure_17() {
  local folder=$1 scene=$out/scenes/city views
  # CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY ...
  mkdir -p "$folder/centred" &&
    "$gpvc" texture "$scene/colmap" "$scene/mesh.ply" -o "$folder/model" >/dev/null &&
    cp "$scene"/colmap/*.txt "$folder/centred" &&
    awk '/^#/ { print; next } { printf "%s", (++n == 1) ? $7 - $3 / 2 " " $8 - $4 / 2 "\n" : "" > offset; $7 = $3 / 2; $8 = $4 / 2; print }' \
      offset="$folder/offset.txt" "$scene/colmap/cameras.txt" >"$folder/centred/cameras.txt" &&
    views=$(awk '!/^#/ && ++n % 2 { print $10 }' "$scene/colmap/images.txt" | sort | awk 'NR % 5 == 1' | paste -sd,) &&
    "$gpvc" evaluate "$folder/model/model.obj" "$scene/colmap" --images "$scene/images" --views "$views" -o "$folder/shader" >"$folder/shader.txt" &&
    "$gpvc" evaluate "$folder/model/model.obj" "$folder/centred" --images "$scene/images" --views "$views" -o "$folder/default" >"$folder/default.txt"
}
[ -d "$out/scenes/city" ] && once figure_17 figure_17
write_page
[ ${#failures[@]} -eq 0 ]
