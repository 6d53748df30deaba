#!/usr/bin/env bash
# keep_uv.sh [OPTION]... SCENE MESH IMAGES -o DIR
#                     gpvc texture --keep-uv on layouts of three kinds, beside new charts
#
#   --hold-out K|LIST  photos that judge the results, as gpvc texture takes them [8]
#   --gpvc FILE        the gpvc to run [build/release/app/gpvc, which is built first]
#
# IMAGES is the folder of the photos, or - where the scene says where they are. The layouts:
#   again      that of the result with new charts: how far its pages differ from those, where faces are (PSNR)
#   udim       the same on pages of 2048 texels, which become UDIM tiles
#   unwrapped  by Blender's smart projection, where there is Blender
# Needs python3 with NumPy and Pillow.
#
# DIR/keep_uv.md is the table that is printed.
set -euo pipefail
export LC_ALL=C
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

hold_out=8
gpvc=
o=
read_arguments "hold-out gpvc o" "$@"
[ ${#places[@]} = 3 ] || usage "expected SCENE, MESH and IMAGES, got ${#places[@]} arguments"
[ -n "$o" ] || usage "-o DIR is missing"
out=$o
images=()
[ "${places[2]}" = - ] || images=(--images "${places[2]}")
python=$(for each in python3 /usr/bin/python3; do "$each" -c 'import numpy, PIL' 2>/dev/null && echo "$each" && break; done) ||
  fail "python3 has no NumPy and Pillow: apt-get install python3-numpy python3-pil"
find_gpvc
mkdir -p "$out"

# textured NAME MESH [OPTION]...
textured() {
  "$gpvc" texture "${places[0]}" "$2" "${images[@]}" --hold-out "$hold_out" -o "$out/$1" --force --texture png "${@:3}" \
    >"$out/$1.log" 2>&1 || fail "gpvc texture failed: $(said_last "$out/$1.log")"
  "$gpvc" evaluate "$out/$1/model.glb" "${places[0]}" "${images[@]}" -o "$out/$1-scores" --force >"$out/$1-scores.log" 2>&1 ||
    fail "gpvc evaluate failed: $(said_last "$out/$1-scores.log")"
}

# row NAME PSNR_OF_PAGES
row() {
  local scores=$out/$1-scores/evaluate.json run=$out/$1/run.json
  printf '| %s | %s | %s | %s | %.2f | %.4f | %.4f | %s |\n' "$1" "$(figure "$run" islands)" "$(figure "$run" mirrored_islands)" \
    "$(figure "$run" overlapping_texels)" "$(figure "$scores" psnr_db)" "$(figure "$scores" ssim)" \
    "$(figure "$scores" one_minus_ncc)" "$2" >>"$out/keep_uv.md"
}

# The models of the two results have the same faces on the same pages.
psnr_of_pages() {
  "$python" - "$1" "$2" <<'PYTHON'
import os, sys
import numpy as np
from PIL import Image, ImageDraw
Image.MAX_IMAGE_PIXELS = None

def read(folder):
    texcoords, faces, pages, page = [], [], {}, None
    for line in open(folder + "/model.mtl"):
        words = line.split()
        if words[:1] == ["newmtl"]: page = words[1]
        if words[:1] == ["map_Kd"]: pages[page] = os.path.join(folder, words[1])
    for line in open(folder + "/model.obj"):
        if line.startswith("vt "): texcoords.append([float(c) for c in line.split()[1:3]])
        elif line.startswith("usemtl "): page = line.split()[1]
        elif line.startswith("f "): faces.append((page, [int(c.split("/")[1]) - 1 for c in line.split()[1:]]))
    return np.array(texcoords), faces, pages

before, after = read(sys.argv[1]), read(sys.argv[2])
images = [{name: np.asarray(Image.open(file).convert("RGB")).astype(float) for name, file in each[2].items()} for each in (before, after)]
masks = {name: Image.new("1", image.shape[1::-1]) for name, image in images[0].items()}
drawn = {name: ImageDraw.Draw(mask) for name, mask in masks.items()}
partner = {}
for (page, corners), (other, _) in zip(before[1], after[1]):
    partner[page] = other
    height, width = images[0][page].shape[:2]
    drawn[page].polygon([(u * width - 0.5, (1 - v) * height - 0.5) for u, v in before[0][corners]], fill=1)
squares = count = 0
for page, other in partner.items():
    a, b = images[0][page], images[1][other]
    if a.shape != b.shape: continue  # cropped, where tiles are not
    difference = (a - b)[np.asarray(masks[page])]
    squares += (difference ** 2).sum()
    count += difference.size
print("%.1f dB" % (10 * np.log10(255 ** 2 * count / squares)) if count and squares else "-")
PYTHON
}

# Tiles from the pages page_0, page_1 ... of a model of ours.
as_udim() {
  "$python" - "$1/model.obj" "$2" <<'PYTHON'
import sys
page_of, page, lines = {}, 0, open(sys.argv[1]).read().splitlines()
for line in lines:
    if line.startswith("usemtl "): page = int(line.split("_")[1])
    elif line.startswith("f "):
        for corner in line.split()[1:]: page_of[int(corner.split("/")[1])] = page
with open(sys.argv[2], "w") as out:
    number = 0
    for line in lines:
        if line.startswith("vt "):
            number += 1
            page = page_of.get(number, 0)
            u, v = (float(c) for c in line.split()[1:3])
            line = "vt %r %r" % (u + page % 10, v + page // 10)
        if not line.startswith(("usemtl ", "mtllib ")): print(line, file=out)
PYTHON
}

{
  echo "| layout | islands | mirrored | texels under several faces | PSNR | SSIM | 1 - NCC | pages beside those with new charts |"
  echo "|---|---|---|---|---|---|---|---|"
} >"$out/keep_uv.md"
textured new "${places[1]}"
row new -
textured again "$out/new/model.obj" --keep-uv
row again "$(psnr_of_pages "$out/new" "$out/again")"
textured small "${places[1]}" --page-size 2048
as_udim "$out/small" "$out/udim.obj"
textured udim "$out/udim.obj" --keep-uv --page-size 2048
row udim "$(psnr_of_pages "$out/small" "$out/udim")"
if command -v blender >/dev/null; then
  cat >"$out/unwrap.py" <<'PYTHON'
import bpy, math, sys
source, target = sys.argv[sys.argv.index("--") + 1:][:2]
bpy.ops.wm.read_factory_settings(use_empty=True)
if source.lower().endswith(".ply"): bpy.ops.import_mesh.ply(filepath=source)
else: bpy.ops.wm.obj_import(filepath=source, forward_axis="Y", up_axis="Z")
bpy.context.view_layer.objects.active = bpy.context.selected_objects[0]
bpy.ops.object.mode_set(mode="EDIT")
bpy.ops.mesh.select_all(action="SELECT")
bpy.ops.uv.smart_project(angle_limit=math.radians(66), island_margin=0.0005)
bpy.ops.object.mode_set(mode="OBJECT")
bpy.ops.wm.obj_export(filepath=target, forward_axis="Y", up_axis="Z", export_normals=False)
PYTHON
  blender -b --python "$out/unwrap.py" -- "${places[1]}" "$out/unwrapped.obj" >"$out/blender.log" 2>&1 ||
    fail "Blender failed: $(said_last "$out/blender.log")"
  textured unwrapped "$out/unwrapped.obj" --keep-uv
  row unwrapped -
fi
cat "$out/keep_uv.md"
