"""Each example does what it says."""

import runpy

import numpy as np

import gpvc
from conftest import EXAMPLES


def example(name):
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


def test_texture_arrays(tmp_path):
    module = example("texture_arrays")
    result = module["main"](tmp_path / "roof.glb")
    assert set(result.labels.tolist()) == {0, 1, 2, 3} and (tmp_path / "roof.glb").stat().st_size > 5e4
    # The texture is the paint: where faces' middles are.
    vertices, faces = module["roof"]()
    x, y, _ = vertices[faces].mean(axis=1).T
    page, uv = result.pages[0], result.uv.mean(axis=1)
    shown = page[(uv[:, 1] * page.shape[0]).astype(int), (uv[:, 0] * page.shape[1]).astype(int)]
    assert np.abs(shown - module["paint"](x, y)).mean() < 4


def test_visibility_masks(city, tmp_path):
    example("visibility_masks")["main"](city.folder / "colmap", city.folder / "mesh.ply", tmp_path)
    for view in city.scene.views:
        head, pixels = (tmp_path / view.name).with_suffix(".pgm").read_bytes().split(b" 255\n", 1)
        mask = np.frombuffer(pixels, np.uint8)
        assert head == b"P5 480 320" and len(mask) == 480 * 320 and set(np.unique(mask)) <= {0, 128, 255}
        assert (mask == 255).mean() > 0.4


def test_transfer_labels(city, tmp_path):
    """Labels that come from faces, in two of the photos, come back to all of them."""
    rng = np.random.default_rng(3)
    truth = rng.integers(0, 4, len(city.mesh.faces))
    pictures = list(gpvc.face_ids(city.mesh.vertices, city.mesh.faces, city.scene, of_photo=True))
    given = [0, 2]
    for i in given:
        labels = np.where(pictures[i] >= 0, truth[pictures[i]], -1)
        labels[rng.random(labels.shape) < 0.1] = 0  # an unsure labeller
        np.save((tmp_path / city.scene.views[i].name).with_suffix(".npy"), labels)
    of_face = example("transfer_labels")["main"](city.folder / "colmap", city.folder / "mesh.ply", tmp_path, tmp_path / "out")
    counts = sum(np.bincount(pictures[i][pictures[i] >= 0], minlength=len(truth)) for i in given)
    known = counts >= 8
    assert known.sum() > 1000 and (of_face[known] == truth[known]).mean() > 0.98 and (of_face[counts == 0] == -1).all()
    back = np.load((tmp_path / "out" / city.scene.views[5].name).with_suffix(".npy"))
    assert (back == np.where(pictures[5] >= 0, of_face[pictures[5]], -1)).all()


def test_colmap_model(city, tmp_path):
    example("colmap_model")["main"](city.folder / "colmap", city.folder / "images", city.folder / "mesh.ply", tmp_path / "model.glb")
    assert (tmp_path / "model.glb").read_bytes() == (city.out / "model.glb").read_bytes()
