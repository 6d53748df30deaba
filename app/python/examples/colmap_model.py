"""A COLMAP model through pycolmap's attributes: python3 colmap_model.py MODEL PHOTOS MESH OUT.glb

With pycolmap installed, Reconstruction(MODEL) is pycolmap's. Without it, the stand-in below reads cameras.txt and images.txt: what
gpvc looks at is cameras (model, width, height, params) and images (name, camera_id, cam_from_world).
"""

import pathlib
import sys
from types import SimpleNamespace

import gpvc

try:
    from pycolmap import Reconstruction
except ImportError:

    def lines_of(file):
        return [line for line in file.read_text().split("\n") if not line.startswith("#")]

    def Reconstruction(folder):
        cameras, images = {}, {}
        for line in lines_of(pathlib.Path(folder, "cameras.txt")):
            if line.strip():
                number, model, width, height, *params = line.split()
                cameras[int(number)] = SimpleNamespace(
                    model=SimpleNamespace(name=model), width=int(width), height=int(height), params=[float(p) for p in params]
                )
        for line in lines_of(pathlib.Path(folder, "images.txt"))[::2]:  # each is followed by a line of points
            if line.strip():
                number, *numbers, camera, name = line.split(maxsplit=9)
                w, x, y, z, *translation = (float(n) for n in numbers)
                pose = SimpleNamespace(rotation=SimpleNamespace(quat=[x, y, z, w]), translation=translation)
                images[int(number)] = SimpleNamespace(name=name, camera_id=int(camera), cam_from_world=lambda pose=pose: pose)
        return SimpleNamespace(cameras=cameras, images=images)


def main(model, photos, mesh_path, out):
    mesh = gpvc.read_mesh(mesh_path)
    scene = gpvc.read_scene(Reconstruction(model), images=photos)
    result = gpvc.texture(mesh.vertices, mesh.faces, scene, progress=True)
    result.save(out)
    print(f"{out}: {len(mesh.faces)} faces from {len(scene.views)} photos")


if __name__ == "__main__":
    main(*sys.argv[1:])
