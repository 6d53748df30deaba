"""Masks for training: python3 visibility_masks.py SCENE MESH OUT

For each photo, a picture OUT/NAME.pgm of its size: 255 where the mesh is seen, 128 where what is seen is in no other photo, so
that nothing can be learned of its depth, and 0 where there is no mesh.
"""

import pathlib
import sys

import numpy as np

import gpvc


def main(scene_path, mesh_path, out):
    scene = gpvc.read_scene(scene_path)
    mesh = gpvc.read_mesh(mesh_path)
    seen_by = gpvc.coverage(mesh.vertices, mesh.faces, scene).photos
    for view, ids in zip(scene.views, gpvc.face_ids(mesh.vertices, mesh.faces, scene, of_photo=True)):
        mask = np.zeros(ids.shape, np.uint8)
        mask[ids >= 0] = np.where(seen_by[ids[ids >= 0]] > 1, 255, 128)
        file = pathlib.Path(out, view.name).with_suffix(".pgm")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"P5 %d %d 255\n" % (view.width, view.height) + mask.tobytes())
        print(f"{file}: {(ids >= 0).mean():.1%} of the pixels show the mesh")


if __name__ == "__main__":
    main(*sys.argv[1:])
