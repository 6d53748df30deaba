#!/usr/bin/env bash
# wheel.sh CHROOT [SCENE MESH]: builds the wheel and textures a scene with it in CHROOT, a Debian 12 with nothing but python3 and
# python3-numpy (debootstrap --variant=minbase --include=python3,python3-numpy bookworm CHROOT). As root. Without SCENE and MESH the
# scene is a synthetic city of the program in build/release. The wheel may have 40 MB.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
[ $# = 1 ] || [ $# = 3 ] || { echo "wheel.sh: expected CHROOT [SCENE MESH]" >&2; exit 2; }
chroot=$1
work=$(mktemp -d "$chroot/tmp/wheel-XXXXXX")
trap 'rm -rf "$work"' EXIT
"$root/app/setup/install_packages.sh" wheel
python=$(command -v /usr/bin/python3)
(cd "$root/app/python" && "$python" -m build --no-isolation --wheel -o "$work" . >"$work/log" 2>&1) || { tail -n 20 "$work/log" >&2; exit 1; }
wheel=$(ls "$work"/*.whl)
bytes=$(stat -c %s "$wheel")
if [ $# = 3 ]; then
  cp -rL "$2" "$work/scene" && cp "$3" "$work/mesh"
else
  "$root/build/release/app/gpvc" synth city -q -o "$work/city" --faces 6000 --size 50 --photos 6 --photo-size 480x320
  mkdir "$work/scene"
  cp -r "$work/city/colmap"/* "$work/city/images" "$work/scene"
  cp "$work/city/mesh.ply" "$work/mesh"
fi
cat >"$work/program.py" <<'PROGRAM'
import gpvc
mesh, scene = gpvc.read_mesh("mesh"), gpvc.read_scene("scene", images="scene")
result = gpvc.texture(mesh.vertices, mesh.faces, scene)
result.save("model.glb")
print("gpvc", gpvc.__version__, result, gpvc.evaluate(result, scene)["mean"]["psnr_db"], "dB")
PROGRAM
inside=/tmp/$(basename "$work")
# No pip there: a wheel is an archive.
chroot "$chroot" /bin/sh -c "cd $inside && python3 -m zipfile -e *.whl site && PYTHONPATH=site python3 program.py && ls -l model.glb &&
  echo of the system: \$(ldd site/gpvc/_gpvc*.so | grep -v /site/ | sed 's/ =>.*//')"
echo "$(basename "$wheel"): $((bytes / 1000000)) MB"
[ "$bytes" -le 40000000 ] || { echo "wheel.sh: more than 40 MB" >&2; exit 1; }
