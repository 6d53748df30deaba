#!/usr/bin/env bash
# quickstart.sh                        make a small synthetic UAV scene and texture it
# quickstart.sh SCENE MESH -o OUT ...  texture your own data (arguments go to `gpvc texture`)
#
# Installs the Debian packages that are missing, builds Release into build/release, runs. Run again, it only runs.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build/release

"$root/app/setup/install_packages.sh" build

if [ ! -f "$build/build.ninja" ]; then
  echo "Configuring $build"
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON >/dev/null
fi
cmake --build "$build" --target gpvc gpvc-texrecon
gpvc=$build/app/gpvc

if [ $# -gt 0 ]; then
  exec "$gpvc" texture "$@"
fi

scene=$root/out/city
result=$root/out/city-textured
[ -f "$scene/mesh.ply" ] || "$gpvc" synth city -o "$scene"
"$gpvc" texture "$scene/colmap" "$scene/mesh.ply" --images "$scene/images" -o "$result" --force
cat <<EOT

Done. Open one of these in any viewer:
  $result/model.obj
  $result/model.glb
  $result/preview.png
Your own data: app/quickstart.sh SCENE MESH -o OUT   (README.md says what SCENE is; more: $gpvc texture --help)
EOT
