"""Which faces views see, and scenes by other objects than files."""

from types import SimpleNamespace

import numpy as np
import pytest

import gpvc
from conftest import run_program, same_files


@pytest.fixture(scope="module")
def seen(city):
    run_program("visibility", city.folder / "colmap", city.folder / "mesh.ply", "-o", city.folder / "seen", "--ivm")
    names = [view.name for view in city.scene.views]
    return SimpleNamespace(
        classes=[np.load(city.folder / "seen" / "visibility" / f"{name}.npy") for name in names],
        faces=[np.load(city.folder / "seen" / "ivm" / f"{name}.npy") for name in names],
    )


def test_classes_are_those_of_the_program(city, seen):
    classes = list(gpvc.visibility(city.mesh.vertices, city.mesh.faces, city.scene))
    assert len(classes) == 6
    for mine, expected in zip(classes, seen.classes):
        assert mine.dtype == np.uint8 and (mine == expected).all()
    other = list(gpvc.visibility(city.mesh.vertices, city.mesh.faces, city.scene, visibility="none"))
    assert (other[0] != classes[0]).any()


def test_face_ids_are_those_of_the_program(city, seen):
    for mine, expected in zip(gpvc.face_ids(city.mesh.vertices, city.mesh.faces, city.scene), seen.faces):
        assert mine.shape == (320, 480) and mine.dtype == np.int32
        assert (mine == expected.astype(np.int32)).all()


def test_views_without_images(city, few):
    sizes = (480, 320)
    classes = gpvc.visibility(city.mesh.vertices, city.mesh.faces, None, few.K, few.poses, few.lenses, image_size=sizes)
    for mine, expected in zip(classes, gpvc.visibility(city.mesh.vertices, city.mesh.faces, city.scene)):
        assert (mine == expected).all()


def test_face_ids_of_the_photo_are_bent_as_it_is(city):
    view = city.scene.views[0]
    frame = next(gpvc.face_ids(city.mesh.vertices, city.mesh.faces, city.scene))
    photo = next(gpvc.face_ids(city.mesh.vertices, city.mesh.faces, city.scene, of_photo=True))
    assert (frame != photo).any()
    # The photo's position of the middle of each frame's pixel, by the lens's formula.
    x, y = np.meshgrid((np.arange(480) + 0.5 - view.K[0, 2]) / view.K[0, 0], (np.arange(320) + 0.5 - view.K[1, 2]) / view.K[1, 1])
    d, r2 = view.distortion, x * x + y * y
    radial = 1 + d["k1"] * r2 + d["k2"] * r2**2
    u = view.K[0, 0] * (x * radial + 2 * d["p1"] * x * y + d["p2"] * (r2 + 2 * x * x)) + view.K[0, 2]
    v = view.K[1, 1] * (y * radial + d["p1"] * (r2 + 2 * y * y) + 2 * d["p2"] * x * y) + view.K[1, 2]
    inside = (u > 0) & (u < 480) & (v > 0) & (v < 320)
    shown = photo[v[inside].astype(int), u[inside].astype(int)]
    assert (shown == frame[inside]).mean() > 0.85  # all but where neighbouring faces meet
    assert (next(gpvc.face_ids(city.mesh.vertices, city.mesh.faces, city.scene))[inside] == shown).mean() > 0.85


def test_masked_pixels_show_no_face(city):
    right = np.ones((320, 480), bool)
    right[:, 240:] = False
    scene = city.scene.with_images(city.images, [right] * 6)
    for ids in gpvc.face_ids(city.mesh.vertices, city.mesh.faces, scene, of_photo=True):
        assert (ids[:, 244:] == -1).all() and (ids[:, :236] >= 0).any()


def test_coverage_is_that_of_the_program(city):
    folder = city.folder / "coverage"
    run_program("coverage", city.folder / "colmap", city.folder / "mesh.ply", "-o", folder)
    told = []
    of_files = gpvc.coverage(city.mesh.vertices, city.mesh.faces, city.scene, progress=lambda *step: told.append(step))
    assert told[-1] == ("coverage", 6, 6)
    of_arrays = gpvc.coverage(city.mesh.vertices, city.mesh.faces, city.scene.with_images(city.images))
    for name, kind in (("photos", np.uint32), ("gsd", np.float32), ("angle", np.float32)):
        expected = np.load(folder / f"coverage_{name}.npy")
        for mine in (getattr(of_files, name), getattr(of_arrays, name)):
            assert mine.dtype == kind and (mine == expected).all()
    assert (of_files.photos == 0).any() and np.isinf(of_files.gsd[of_files.photos == 0]).all()


def test_coverage_counts_no_masked_pixels(city, few):
    left = np.zeros((320, 480), bool)
    left[:, :240] = True
    whole, half = (
        gpvc.coverage(city.mesh.vertices, city.mesh.faces, None, few.K, few.poses, few.lenses, masks, image_size=(480, 320))
        for masks in (None, [left] * 6)
    )
    assert (half.photos <= whole.photos).all() and 0.2 < half.photos.sum() / whole.photos.sum() < 0.8


def reconstruction(folder, new):
    """Objects with pycolmap's attributes; `new`: as from version 3.12 on, where poses are functions."""
    cameras, images = {}, {}
    for line in (folder / "cameras.txt").read_text().splitlines():
        if not line.startswith("#"):
            number, model, width, height, *params = line.split()
            named = {"model": SimpleNamespace(name=model)} if new else {"model": 4, "model_name": model}
            cameras[int(number)] = SimpleNamespace(width=int(width), height=int(height), params=np.array(params, float), **named)
    for line in [line for line in (folder / "images.txt").read_text().split("\n") if not line.startswith("#")][::2]:
        if line:
            number, w, x, y, z, *t, camera, name = line.split(maxsplit=9)
            rotation = SimpleNamespace(quat=np.array([x, y, z, w], float))
            pose = SimpleNamespace(rotation=rotation, translation=np.array(t, float))
            images[int(number)] = SimpleNamespace(
                name=name, camera_id=int(camera), cam_from_world=(lambda pose=pose: pose) if new else pose, has_pose=True
            )
    images[99] = SimpleNamespace(name="unregistered.jpg", camera_id=1, has_pose=False)
    return SimpleNamespace(cameras=cameras, images=images)


@pytest.mark.parametrize("new", [False, True])
def test_a_colmap_model_by_pycolmaps_attributes(city, tmp_path, new):
    scene = gpvc.read_scene(reconstruction(city.folder / "colmap", new), images=city.folder / "images")
    assert [view.name for view in scene.views] == [view.name for view in city.scene.views]
    gpvc.texture(city.mesh.vertices, city.mesh.faces, scene).save(tmp_path / "model.glb")
    same_files(city.out, tmp_path, ["model.glb"])


def test_rotations_by_their_matrix(city):
    from gpvc._cameras import _quaternion

    rng = np.random.default_rng(5)
    for axis in [*rng.normal(size=(40, 3)), *np.eye(3), *-np.eye(3)]:
        for angle in (0.0, 1e-9, 1.0, np.pi / 2, 3.0, np.pi):
            u = axis / np.linalg.norm(axis)
            w, (x, y, z) = np.cos(angle / 2), np.sin(angle / 2) * u
            m = np.array([
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ])
            q = np.array(_quaternion(SimpleNamespace(matrix=lambda m=m: m)))
            assert np.allclose(q, [w, x, y, z], atol=1e-12) or np.allclose(-q, [w, x, y, z], atol=1e-12)


def test_scenes_of_other_formats(city, tmp_path):
    run_program("convert", city.folder / "colmap", "-o", tmp_path / "nerf", "--format", "transforms")
    scene = gpvc.read_scene(tmp_path / "nerf")
    assert len(scene.views) == 6 and scene.format != city.scene.format
    half = gpvc.read_scene(city.folder / "colmap", downscale=2)
    assert (half.views[0].width, half.views[0].height) == (240, 160)
