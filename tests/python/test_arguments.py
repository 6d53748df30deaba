"""Bad input: one exception, whose sentence names the argument and no option of the command line."""

import os
import re

import numpy as np
import pytest

import gpvc

WIDTH, HEIGHT = 32, 24
VERTICES = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])
K = np.array([[30, 0, 16], [0, 30, 12], [0, 0, 1]], float)
POSE = np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 3]], float)
IMAGES = np.random.default_rng(1).integers(0, 255, (2, HEIGHT, WIDTH, 3), np.uint8)


def good():
    return dict(vertices=VERTICES, faces=FACES, images=list(IMAGES), K=K, camera_from_world=[POSE, POSE])


def changed(array, index, value):
    array = np.array(array, float)
    array[index] = value
    return array


# What is given, the exception, and the beginning of its sentence.
BAD = [
    ({"vertices": VERTICES[:, :2]}, ValueError, "vertices has shape (4, 2), expected (V, 3)"),
    ({"vertices": changed(VERTICES, (1, 2), np.nan)}, ValueError, "vertices[1, 2] is nan, expected finite numbers"),
    ({"vertices": changed(VERTICES, (3, 0), np.inf)}, ValueError, "vertices[3, 0] is inf"),
    ({"vertices": changed(VERTICES, (0, 0), 1e20)}, ValueError, "vertices: expected coordinates up to 1e18"),
    ({"vertices": [["a", "b", "c"]]}, ValueError, "vertices: expected an array of numbers"),
    ({"vertices": [[0, 0, 0], [1, 1]]}, ValueError, "vertices: expected an array of numbers"),
    ({"faces": [[0, 1, 4]]}, ValueError, "faces[0, 2] is 4, expected 0 to 3"),
    ({"faces": [[0, 1, 2], [0, -1, 2]]}, ValueError, "faces[1, 1] is -1, expected 0 to 3"),
    ({"faces": FACES.astype(float)}, ValueError, "faces has elements of float64, expected whole numbers"),
    ({"faces": FACES[:, :2]}, ValueError, "faces has shape (2, 2), expected (F, 3)"),
    ({"faces": FACES[:0]}, ValueError, "faces has no faces"),
    ({"faces": FACES.ravel()}, ValueError, "faces has shape (6,)"),
    ({"images": list(IMAGES[:1])}, ValueError, "images has 1 entries, expected 2"),
    ({"images": [IMAGES[0], IMAGES[1][..., :0]]}, ValueError, "images[1] has shape (24, 32, 0)"),
    ({"images": [IMAGES[0], np.zeros((HEIGHT, WIDTH, 7), np.uint8)]}, ValueError, "images[1] has shape (24, 32, 7)"),
    ({"images": [IMAGES[0], IMAGES[1].astype(np.int64)]}, ValueError, "images[1] has samples of int64"),
    ({"images": [IMAGES[0], "no such file.jpg"]}, ValueError, "no such file.jpg"),
    ({"images": IMAGES[0, :, :, 0]}, ValueError, "images has shape (24, 32)"),
    ({"images": 7}, TypeError, "images: expected a list of arrays and paths, or a function, got int"),
    ({"images": None}, ValueError, "image_size: expected (width, height)"),
    ({"images": lambda i: IMAGES[i].astype(np.complex64)}, ValueError, "images(0) has samples of complex64"),
    ({"images": lambda i: IMAGES[i][: HEIGHT - 4 * i]}, ValueError, "images(1) is 32 x 20 pixels, expected 32 x 24"),
    ({"images": lambda i: IMAGES[i], "image_size": (64, 48)}, ValueError, "images(0) is 32 x 24 pixels, expected 64 x 48"),
    ({"images": list(IMAGES), "image_size": [(32, 24), (32, 25)]}, ValueError, "images[1] is 32 x 24 pixels, expected 32 x 25"),
    ({"image_size": (0, 5)}, ValueError, "image_size: expected (width, height)"),
    ({"image_size": (1.5, 5)}, ValueError, "image_size: expected (width, height)"),
    ({"K": K[:2]}, ValueError, "K has shape (2, 3), expected (3, 3) or (2, 3, 3)"),
    ({"K": [K] * 3}, ValueError, "K has shape (3, 3, 3), expected (3, 3) or (2, 3, 3)"),
    ({"K": changed(K, (0, 0), np.nan)}, ValueError, "K[0, 0] is nan"),
    ({"K": changed(K, (0, 0), -30)}, ValueError, "K: expected focal lengths above 0"),
    ({"K": changed(K, (0, 1), 2)}, ValueError, "K: expected [[fx, 0, cx]"),
    ({"K": changed(K, (2, 2), 2)}, ValueError, "K: expected [[fx, 0, cx]"),
    ({"K": None}, ValueError, "K: expected an array"),
    ({"camera_from_world": None}, ValueError, "camera_from_world: expected an array"),
    ({"camera_from_world": POSE}, ValueError, "camera_from_world has shape (3, 4), expected (N, 3, 4) or (N, 4, 4)"),
    ({"camera_from_world": np.zeros((0, 3, 4))}, ValueError, "camera_from_world has no poses"),
    ({"camera_from_world": [2 * POSE, POSE]}, ValueError, "camera_from_world[0] has no rotation"),
    ({"camera_from_world": [POSE, POSE * [[-1], [1], [1]]]}, ValueError, "camera_from_world[1] has no rotation"),
    ({"camera_from_world": [POSE, changed(POSE, (2, 3), np.inf)]}, ValueError, "camera_from_world[1, 2, 3] is inf"),
    ({"camera_from_world": [np.vstack([POSE, [0, 0, 1, 1]])] * 2}, ValueError, "camera_from_world[0] has the last row"),
    ({"distortion": [0.1, 0.2, 0.3]}, ValueError, "distortion has shape (3,)"),
    ({"distortion": 0.1}, ValueError, "distortion: expected OpenCV's coefficients"),
    ({"distortion": {"model": "magic"}}, ValueError, "distortion: there is no lens model 'magic'"),
    ({"distortion": {"k9": 1}}, ValueError, "distortion: model 'opencv' has no term 'k9'"),
    ({"distortion": [{"k1": 0}] * 3}, ValueError, "distortion has 3 entries, expected one for each of 2"),
    ({"distortion": [0, np.nan, 0, 0]}, ValueError, "distortion[1] is nan"),
    ({"masks": [None]}, ValueError, "masks has 1 entries, expected 2"),
    ({"masks": [None, np.ones((5, 5), bool)]}, ValueError, "masks[1] is 5 x 5 pixels, expected 32 x 24"),
    ({"masks": [None, np.ones(5, bool)]}, ValueError, "masks[1] has shape (5,), expected (H, W)"),
    ({"masks": [None, np.ones((HEIGHT, WIDTH), np.int32)]}, ValueError, "masks[1] has samples of int32"),
    ({"masks": lambda i: np.ones((5, 5), bool)}, ValueError, "masks("),
    ({"views": []}, ValueError, "views: expected at least one"),
    ({"views": [2]}, ValueError, "views: 2 is no index of the 2 views"),
    ({"views": ["east"]}, ValueError, "views: there is no view 'east'"),
    ({"threads": -1}, ValueError, "threads=-1"),
    ({"page_size": 100}, ValueError, "page_size=100: expected 256 to 32768"),
    ({"page_size": 1024.5}, TypeError, "page_size: expected a whole number"),
    ({"page_size": "1024"}, TypeError, "page_size: expected a whole number"),
    ({"texture": "gif"}, ValueError, "texture='gif': expected 'jpg', 'png'"),
    ({"normals": 1}, TypeError, "normals: expected True or False, got int"),
    ({"memory": "lots"}, ValueError, "memory='lots': expected an amount"),
    ({"memory": -5}, ValueError, "memory=-5"),
    ({"smoothness": float("nan")}, ValueError, "smoothness=nan"),
    ({"unseen_color": (1, 2)}, ValueError, "unseen_color: expected three numbers"),
    ({"unseen_color": (1, 2, 300)}, ValueError, "unseen_color: expected three numbers"),
    ({"visibility": "magic"}, ValueError, "visibility: "),
    ({"visibility": "ray:dense:0.1"}, ValueError, "visibility='ray:dense:0.1': rays are traced by the program alone"),
    ({"max_bytes": 1000}, ValueError, "max_bytes belongs to target='web'"),
    ({"target": "web", "page_size": 20000}, ValueError, "page_size=20000: a WebP"),
    ({"pagesize": 1024}, TypeError, "texture() got an unexpected keyword argument 'pagesize'; did you mean 'page_size'?"),
    ({"resume": "never"}, TypeError, "texture() got an unexpected keyword argument 'resume'"),
    ({"progress": 5}, TypeError, "progress: expected True, False or a function"),
    ({"mesh_crs": "EPSG:25832"}, ValueError, ""),  # the cameras have no reference system
]


@pytest.mark.parametrize("given, kind, sentence", BAD, ids=[f"{i}_{'_'.join(given)}" for i, (given, _, _) in enumerate(BAD)])
def test_bad_input_is_one_exception_that_names_the_argument(given, kind, sentence):
    with pytest.raises(kind) as raised:
        gpvc.texture(**{**good(), **given})
    said = str(raised.value)
    assert said.startswith(sentence), said
    assert not re.search(r"(^|\s)--?[a-z]", said), said


def test_what_photos_do_not_see_is_said_of_the_arguments():
    for change in ({"vertices": VERTICES + 1000}, {"vertices": VERTICES * 1e-6}):
        with pytest.raises(gpvc.InputError) as raised:
            gpvc.texture(**{**good(), **change})
        assert "vertices, faces" in str(raised.value)
        assert "--" not in str(raised.value)


def test_a_scene_brings_its_own_cameras(city):
    for name, value in {"K": K, "camera_from_world": [POSE], "distortion": [0] * 4, "masks": [None], "image_size": (4, 4)}.items():
        with pytest.raises(ValueError, match=f"^{name}: "):
            gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene, **{name: value})


def test_photos_of_other_sizes_than_the_cameras(city):
    small = [image[::2, ::2] for image in city.images]
    with pytest.raises(ValueError, match=r"^images\[0\] is 240 x 160 pixels, expected 480 x 320, the size of its camera$"):
        city.scene.with_images(small)
    with pytest.raises(ValueError, match=r"^images\([0-5]\) is 240 x 160 pixels, expected 480 x 320"):
        gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene.with_images(lambda i: small[i]))


def test_files_that_are_not_there(tmp_path):
    for call in (lambda: gpvc.read_scene(tmp_path / "none"), lambda: gpvc.read_mesh(tmp_path / "none.ply"),
                 lambda: gpvc.texture(VERTICES, FACES, tmp_path / "none")):
        with pytest.raises(gpvc.InputError, match="none"):
            call()
    with pytest.raises(TypeError, match="^path: expected a path, got int"):
        gpvc.read_mesh(5)
    with pytest.raises(ValueError, match="^downscale=65: expected 1 to 64"):
        gpvc.read_scene(tmp_path, downscale=65)


def test_saving_where_it_cannot_be(city, tmp_path):
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene)
    for name in ("none/model.glb", "none/model.obj"):
        with pytest.raises(gpvc.OutputError) as raised:
            result.save(tmp_path / name)
        assert isinstance(raised.value, OSError) and "none" in str(raised.value)
    with pytest.raises(ValueError, match="^path: .* ends in .stl"):
        result.save(tmp_path / "model.stl")
    (tmp_path / "taken.obj").mkdir()
    with pytest.raises(gpvc.OutputError, match="taken.obj"):
        result.save(tmp_path / "taken.obj")
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == [], "nothing half-written is left"


def test_the_errors_of_the_library_have_their_measures_and_ways_out():
    far = VERTICES.copy()
    far[2:] += 1000  # one of the faces' corners: photos see less than was asked for
    vertices = np.concatenate([VERTICES] + [VERTICES + [1000 + 10 * i, 0, 0] for i in range(60)])
    faces = np.concatenate([FACES + 4 * i for i in range(61)])
    with pytest.raises(gpvc.Error) as raised:
        gpvc.texture(**{**good(), "vertices": vertices, "faces": faces})
    assert "allow_unseen=True" in str(raised.value), raised.value
    assert raised.value.measures


def test_names_that_are_no_utf8_are_named_by_their_bytes(tmp_path):
    name = os.path.join(os.fsencode(tmp_path), b"caf\xe9.ply")
    with open(name, "wb") as file:
        file.write(b"ply\n")
    with pytest.raises(gpvc.InputError) as raised:
        gpvc.read_mesh(os.fsdecode(name))
    assert r"caf\xe9.ply" in str(raised.value), raised.value
