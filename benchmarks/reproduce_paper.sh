#!/usr/bin/env bash
# reproduce_paper.sh [--quick] [DIR]   from nothing to DIR (default: out/paper, out/paper-quick) with tables 1 to 9 and the comparisons
#                                      of figures 15, 17 and 21 to 26 of Huang, Zhu, Jiang 2018, each beside what the
#                                      paper says, in DIR/index.html and DIR/index.md
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
out=
for word in "$@"; do
  case $word in
    --quick) quick=yes ;;
    -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "reproduce_paper.sh: there is no option '$word'; usage: reproduce_paper.sh [--quick] [DIR]" >&2; exit 2 ;;
    *) out=$word ;;
  esac
done
if [ -z "$out" ]; then
  out=$root/out/paper
  [ $quick = yes ] && out=$root/out/paper-quick
fi
data=${DATA:-$root/../shared/data}

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
page=$out/index.html.unfinished
text=$out/index.md.unfinished

if [ $quick = yes ]; then
  city=(--faces 20000 --photos 10 --photo-size 720x480)
  terrain=(--gap 0.01 --faces 20000 --photos 10 --photo-size 720x480) slits=(--photos 10 --photo-size 720x480)
  modes=none,shadow-map:spc,shadow-map:apc,ray:sparse,ray:dense,gpvc:uncorrected,gpvc,gpvc:ves
  compare=(--eps 1e-4,1e-2 --oracle-views 2 --score-views 4 --crops 4)
  accuracy=(--quick) efficiency=(--views 2)
else
  city=(--faces 324000 --photos 40 --photo-size 3000x2000)
  terrain=(--gap 0.01) slits=()
  modes=none,shadow-map:spc,shadow-map:apc,ray:sparse,ray:dense,gpvc:uncorrected,gpvc,gpvc:ves
  compare=(--oracle-views 3)
  accuracy=() efficiency=()
fi

# --- what is run ----------------------------------------------------------------------------------------------------

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
failures=()

accuracy_tables() { mkdir -p "$1" && "$build/benchmarks/accuracy" -o "$1" "${accuracy[@]}" >"$1/accuracy.txt"; }
efficiency_tables() { mkdir -p "$1" && "$build/benchmarks/efficiency" -o "$1" "${efficiency[@]}" >"$1/efficiency.md"; }
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
scenes=()
for name in city slits terrain; do
  [ -d "$out/scenes/$name" ] || continue
  once "compare_$name" compared "$out/scenes/$name/colmap" "$out/scenes/$name/mesh.ply" --modes "$modes" --hold-out 5 "${compare[@]}"
  [ -f "$out/compare_$name/report.json" ] && reports+=("$out/compare_$name/report.json") && scenes+=("$name")
done
missing=()
for name in brighton sceaux; do
  if [ -f "$data/$name/mesh.ply" ]; then
    reduced=()
    [ $quick = yes ] && reduced=(--downscale 4)
    once "compare_$name" compared "$data/$name/colmap" "$data/$name/mesh.ply" --modes "$modes" --hold-out 5 "${compare[@]}" "${reduced[@]}"
    [ -f "$out/compare_$name/report.json" ] && scenes+=("$name")
  else
    missing+=("$name")
  fi
done
[ ${#reports[@]} -gt 0 ] && once summary "$gpvc" compare --summarize "${reports[@]}" -o

# Figure 15: two depth buffers, nothing corrected. Figure 17: cameras whose principal point is put into the middle.
figure_15() { "$gpvc" compare "$out/scenes/$1/colmap" "$out/scenes/$1/mesh.ply" --modes gpvc:uncorrected:spc,gpvc:uncorrected,gpvc "${compare[@]}" -o "$2" >/dev/null; }
once figure_15 figure_15 slits
once figure_15_terrain figure_15 terrain
# The steps hang together by &&, as `once` asks for the outcome and so switches `set -e` off.
figure_17() {
  local folder=$1 city=$out/scenes/city views
  # CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY ...
  mkdir -p "$folder/centred" &&
    "$gpvc" texture "$city/colmap" "$city/mesh.ply" -o "$folder/model" >/dev/null &&
    cp "$city"/colmap/*.txt "$folder/centred" &&
    awk '/^#/ { print; next } { printf "%s", (++n == 1) ? $7 - $3 / 2 " " $8 - $4 / 2 "\n" : "" > offset; $7 = $3 / 2; $8 = $4 / 2; print }' \
      offset="$folder/offset.txt" "$city/colmap/cameras.txt" >"$folder/centred/cameras.txt" &&
    views=$(awk '!/^#/ && ++n % 2 { print $10 }' "$city/colmap/images.txt" | sort | awk 'NR % 5 == 1' | paste -sd,) &&
    "$gpvc" evaluate "$folder/model/model.obj" "$city/colmap" --images "$city/images" --views "$views" -o "$folder/shader" >"$folder/shader.txt" &&
    "$gpvc" evaluate "$folder/model/model.obj" "$folder/centred" --images "$city/images" --views "$views" -o "$folder/default" >"$folder/default.txt"
}
[ -d "$out/scenes/city" ] && once figure_17 figure_17
non_manifold() { "$gpvc" inspect "$1/colmap" "$1/mesh.ply" 2>/dev/null | sed -n 's/.*, \([0-9 ]*\) non-manifold faces.*/\1/p'; }

# --- what is said of it ---------------------------------------------------------------------------------------------

: >"$page"
: >"$text"
html() { sed 's/&/\&amp;/g; s/</\&lt;/g; s/>/\&gt;/g' <<<"$1" | sed 's/\[\([^]]*\)\](\([^)]*\))/<a href="\2">\1<\/a>/g'; }
head2() { printf '\n## %s\n' "$1" >>"$text"; printf '<h2>%s</h2>\n' "$(html "$1")" >>"$page"; }
says() { printf '\n%s: %s\n' "$1" "$2" >>"$text"; printf '<p><b>%s:</b> %s</p>\n' "$(html "$1")" "$(html "$2")" >>"$page"; }

# figure NAME MODE COLUMN: a cell of compare_NAME/report.md, empty where there is none.
figure() {
  awk -F' *[|] *' -v mode="$2" -v column="$3" '
    /^[|] mode/ { at = 0; for (i = 2; i < NF; ++i) { split($i, part, ","); if (part[1] == column) at = i } }
    { split($2, words, " ") }
    at && words[1] == mode { print $at }' "$out/$1/report.md"
}
# biases REPORT FAMILY COLUMN: "EPSILON VALUE" lines by rising epsilon.
biases() {
  awk -F' *[|] *' -v family="$2:" -v column="$3" '
    /^[|] mode/ { at = 0; for (i = 2; i < NF; ++i) { split($i, part, ","); if (part[1] == column) at = i } }
    at && index($2, family) == 1 { split(substr($2, length(family) + 1), words, " "); print words[1], $at }' \
    "$out/$1/report.md" | sort -g
}
listed() { awk '{ printf("%s%s at %s", (NR > 1 ? ", " : ""), ($2 == "" ? "none" : $2 " %"), $1) }'; }
# over SCENES FAMILY PAPER_TREND: the family's agreement by epsilon on every scene, and whether it moves as in the paper.
by_epsilon() {
  local family=$1 rule=$2 scene
  for scene in "${scenes[@]}"; do
    local values none ours verdict
    values=$(biases "compare_$scene" "$family" "Agreement with the oracle")
    [ -n "$values" ] || continue
    none=$(figure "compare_$scene" none "Agreement with the oracle")
    ours=$(figure "compare_$scene" gpvc "Agreement with the oracle")
    verdict=$(awk -v rule="$rule" -v none="${none:-0}" '
      NF == 2 { v[++n] = $2; if (n == 1 || $2 > most) { most = $2; best = $1 } if (n == 1 || $2 < least) least = $2; last = $1 }
      END {
        for (i = 2; i <= n; ++i) if (v[i] < v[i - 1] - 0.0005) fell = 1; else if (v[i] > v[i - 1] + 0.0005) rose = 1
        if (rule == "rises") print (rose && !fell) ? "As in the paper it gets better as epsilon grows." : \
          !rose && !fell ? "Here epsilon changes nothing." : "It differs from the paper: the best epsilon here is " best ", and it gets worse to a side of it."
        if (rule == "flat") print (most - least < 1 ? "As in the paper epsilon hardly matters" : "It differs from the paper: epsilon matters by " sprintf("%.2f", most - least) " points") \
          "; no test at all agrees on " none " %, " sprintf("%.2f", most > none ? most - none : none - most) " points from the best of these."
        if (rule == "middle") print rose && fell ? "As in the paper small and large ones both fail; the best here is " best "." : \
          "Within these epsilons it differs from the paper, where both ends fail: it " (rose ? "only gains" : fell ? "only loses" : "does not change") " as epsilon grows."
      }' <<<"$values")
    says "Here, $scene" "agreement with the exact oracle $(listed <<<"$values"); gpvc $ours %. $verdict [Report](compare_$scene/report.html)"
  done
}

{
  printf '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
  printf '<meta name="color-scheme" content="light dark"><title>GPVC, reproduced</title><style>:root{color-scheme:light dark}'
  printf 'body{font:16px/1.55 system-ui,sans-serif;max-width:76ch;margin:40px auto;padding:0 20px}h1{line-height:1.15}h2{margin:48px 0 4px;font-size:20px}p{margin:8px 0}</style>'
  printf '<h1>GPVC (Huang, Zhu, Jiang 2018), reproduced</h1>\n'
} >>"$page"
printf '# GPVC (Huang, Zhu, Jiang 2018), reproduced\n' >>"$text"
says "Made by" "$("$gpvc" --version) on $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $(nproc) processors; $("$gpvc" --device list | head -1)"
[ $quick = yes ] && says "Quick" "smaller scenes and fewer epsilons than without --quick; the figures are rougher."
if [ ${#missing[@]} -gt 0 ]; then says "Not there" "the real scenes ${missing[*]}, looked for in $data: what follows is of the synthetic scenes alone."; fi
says "Not comparable" "the paper's own scenes (Wuhan University; ISPRS and EuroSDR) and its screenshots are not published; scenes of known truth and figures stand in for them."

head2 "Tables 1 to 6: accuracy"
says "Paper" "a depth map or rays are right within a range of epsilons that differs from model to model; GPVC is right on 99.1 to 99.3 % of the faces before and 100 % after the coverage correction."
says "Here" "[the tables beside the paper's](tables_1_to_6/accuracy.md)"
head2 "Tables 7 to 9: efficiency"
says "Paper" "611 055 faces, 43 views, GTX 860M: shadow maps 20.5 to 40.8 s, sparse rays 110 to 261 s, dense rays 707 to 1666 s, GPVC 24.7 to 30.1 s on the CPU and 0.11 to 0.16 s on the GPU."
says "Here" "[the tables](tables_7_to_9/efficiency.md), on this machine; without a graphics card GPVC draws natively, and with Mesa's llvmpipe in the rows marked opengl, as shadow maps do, so only the order of the methods compares."

head2 "Figure 15: default and reversed depth"
says "Paper" "very close faces fight in the default, symmetric depth buffer and do not in the reversed one."
for name in figure_15 figure_15_terrain; do
  [ -f "$out/$name/report.md" ] || continue
  spc=$(figure $name gpvc:uncorrected:spc "Agreement with the oracle")
  apc=$(figure $name gpvc:uncorrected "Agreement with the oracle")
  verdict=$(awk -v a="$spc" -v b="$apc" 'BEGIN { print((b > a ? "As in the paper the reversed buffer is better." : b == a ? "It differs from the paper: both are the same here." : "It differs from the paper: the symmetric buffer is better here.")) }')
  says "Here, $([ $name = figure_15 ] && echo slits || echo terrain)" "uncorrected classes agree with the exact oracle on $spc % in the symmetric and $apc % in the reversed buffer; $(figure $name gpvc "Agreement with the oracle") % corrected. $verdict [Report]($name/report.html)"
done
head2 "Figure 17: off-centre projection"
says "Paper" "the default rendering puts the principal point into the middle and dislocates objects, by more than 50 and 90 pixels in an 8176 x 6132 photo; the shader-based one keeps them aligned."
if [ -d "$out/figure_17" ]; then
  error() { awk '$1 == "mean" { print $5 }' "$out/figure_17/$1.txt"; }
  verdict=$(awk -v a="$(error default)" -v b="$(error shader)" 'BEGIN { print((a > b ? "As in the paper the centred rendering is dislocated." : "It differs from the paper: centring costs nothing here.")) }')
  says "Here, city" "principal point $(head -1 "$out/figure_17/offset.txt") pixels off the middle; 1 - NCC of renders against photos $(error default) when it is put into the middle, $(error shader) as calibrated. $verdict Photo, render and error side by side: [centred](figure_17/default/), [calibrated](figure_17/shader/)"
fi
head2 "Figure 21: shadow map with symmetric projection"
says "Paper" "highly sensitive to the bias; the texturing gets better as it grows from 0.00001 to 0.01."
by_epsilon shadow-map:spc rises
head2 "Figure 22: shadow map with asymmetric projection"
says "Paper" "insensitive to the bias, and nearly as without visibility tests: almost all faces pass."
by_epsilon shadow-map:apc flat
head2 "Figure 23: sparse rays"
says "Paper" "small biases leave holes, as faces occlude themselves; large ones let occluded texture in."
by_epsilon ray:sparse middle
head2 "Figure 24: dense rays"
says "Paper" "as sparse rays, not obviously better, and at some epsilons worse."
by_epsilon ray:dense middle
head2 "Figure 25: without test, uncorrected, HIVERS, VES"
says "Paper" "without a test serious errors, without the coverage correction some artifacts, corrected none; HIVERS and VES differ only where the mesh is not manifold."
for scene in "${scenes[@]}"; do
  row=
  for mode in none gpvc:uncorrected gpvc gpvc:ves; do row+="${row:+, }$mode $(figure "compare_$scene" $mode "Agreement with the oracle") %"; done
  verdict=$(awk -v n="$(figure "compare_$scene" none "Agreement with the oracle")" -v u="$(figure "compare_$scene" gpvc:uncorrected "Agreement with the oracle")" \
    -v g="$(figure "compare_$scene" gpvc "Agreement with the oracle")" 'BEGIN { print((n < u && u < g) ? "The order is the paper'"'"'s." : "The order differs from the paper'"'"'s.") }')
  wrong=$(figure "compare_$scene" gpvc "From another surface")
  [ -n "$wrong" ] && row+="; textured from pixels of another surface: none $(figure "compare_$scene" none "From another surface") %, uncorrected $(figure "compare_$scene" gpvc:uncorrected "From another surface") %, gpvc $wrong %"
  says "Here, $scene" "agreement with the exact oracle: $row. $verdict [Report](compare_$scene/report.html)"
done
head2 "Figure 26: non-manifold parts"
says "Paper" "trees that are not reconstructed completely are where VES and HIVERS differ."
for scene in "${scenes[@]}"; do
  folder=$out/scenes/$scene
  [ -d "$folder" ] || folder=$data/$scene
  count=$(non_manifold "$folder" || true)
  full=$(figure "compare_$scene" gpvc "V: full") ves=$(figure "compare_$scene" gpvc:ves "V: full")
  verdict=$([ "$full" = "$ves" ] && echo "VES and HIVERS call the same number full." || echo "VES calls $ves pairs full, HIVERS $full: an occluder that projects inside a face escapes VES, on a manifold mesh as well.")
  says "Here, $scene" "${count:-0} non-manifold faces. $verdict"
done
head2 "Does a bias win anywhere?"
says "Paper" "GPVC is compared by eye."
for scene in "${scenes[@]}"; do
  while read -r line; do says "Here, $scene" "$line"; done < <(sed -n 's/^- \(By .*\)/\1/p' "$out/compare_$scene/report.md")
done
head2 "No single epsilon"
says "Paper" "no bias is robust for every part of a complex model."
if [ -f "$out/summary/summary.md" ]; then
  while read -r line; do says "Here" "$line"; done < <(sed -n '/^By /p' "$out/summary/summary.md")
  says "Tables" "[points behind gpvc, by mode and scene](summary/summary.html)"
fi
if [ ${#failures[@]} -gt 0 ]; then says "Failed" "${failures[*]}; see what was printed."; fi
mv "$page" "$out/index.html"
mv "$text" "$out/index.md"
echo "$out/index.html"
[ ${#failures[@]} -eq 0 ]
