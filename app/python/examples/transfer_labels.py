"""Labels of pixels to faces and back: python3 transfer_labels.py SCENE MESH LABELS OUT

LABELS has NAME.npy for each photo that is labelled, of its size: (H, W) whole numbers from 0 on, -1 where nothing is known. Each
face takes the label that most of its pixels have, of all photos together. OUT gets NAME.npy for all photos: those labels where the
photo sees the faces, -1 elsewhere.
"""

import pathlib
import sys

import numpy as np

import gpvc


def main(scene_path, mesh_path, labels, out):
    scene = gpvc.read_scene(scene_path)
    mesh = gpvc.read_mesh(mesh_path)
    pictures = list(gpvc.face_ids(mesh.vertices, mesh.faces, scene, of_photo=True))

    votes = {}  # by label, for each face
    for view, ids in zip(scene.views, pictures):
        file = pathlib.Path(labels, view.name).with_suffix(".npy")
        if not file.exists():
            continue
        given = np.load(file)
        for label in np.unique(given[given >= 0]):
            shown = ids[(given == label) & (ids >= 0)]
            votes.setdefault(int(label), np.zeros(len(mesh.faces), int))[:] += np.bincount(shown, minlength=len(mesh.faces))
    names = np.array(sorted(votes))
    table = np.stack([votes[name] for name in names])
    of_face = np.where(table.max(axis=0) > 0, names[table.argmax(axis=0)], -1)
    print(f"{(of_face >= 0).sum()} of {len(of_face)} faces have one of the labels {names.tolist()}")

    for view, ids in zip(scene.views, pictures):
        file = pathlib.Path(out, view.name).with_suffix(".npy")
        file.parent.mkdir(parents=True, exist_ok=True)
        np.save(file, np.where(ids >= 0, of_face[ids], -1))
    return of_face


if __name__ == "__main__":
    main(*sys.argv[1:])
