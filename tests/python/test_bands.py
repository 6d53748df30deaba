"""Photos of more bits and bands: samples that pages keep as they are."""

import os

import numpy as np
import pytest

import gpvc
from conftest import run_program, same_files

NAMES = ["Blue", "Green", "Red", "Red edge", "NIR"]


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """A small city in five bands of 16 bits, in files of their own, textured by the program."""
    folder = tmp_path_factory.mktemp("bands")
    run_program("synth", "city", "-o", folder, "--force", "--faces", 6000, "--size", 50, "--photos", 6, "--photo-size", "480x320",
                "--bands", 5, "--depth", 16)
    run_program("texture", folder / "colmap", folder / "mesh.ply", "-o", folder / "out")
    return folder


def test_files_give_the_bytes_of_the_program(flight, tmp_path):
    scene, mesh = gpvc.read_scene(flight / "colmap"), gpvc.read_mesh(flight / "mesh.ply")
    assert len(scene.bands) == 5
    result = gpvc.texture(mesh.vertices, mesh.faces, scene)
    assert result.bands == scene.bands
    assert [s.shape for s in result.samples] == [(*page.shape[:2], 5) for page in result.pages]
    assert result.samples[0].dtype == np.uint16
    result.save(tmp_path / "whole")
    result.save(tmp_path / "model.obj")
    result.save(tmp_path / "model.glb")
    files = ["model.obj", "model.mtl", "model_0.jpg", "model_0.tif", "model.glb"]
    same_files(flight / "out", tmp_path, files)
    same_files(flight / "out", tmp_path / "whole", files)
    gained = gpvc.texture(mesh.vertices, mesh.faces, scene, band_gains=True)
    assert (gained.samples[0] != result.samples[0]).any()


def samples_of_views(city, type, scale):
    """Pictures of one value a band, which says the view and the band."""
    values = lambda i: (np.arange(5) + 10 * (i + 1)) * scale
    return [np.broadcast_to(values(i), (320, 480, 5)).astype(type) for i in range(6)], values


def shown(result, face):
    """The samples in the middle of a face."""
    page = result.samples[result.page[face]]
    u, v = result.uv[face].mean(axis=0)
    return page[int(v * page.shape[0]), int(u * page.shape[1])]


@pytest.mark.parametrize("type, scale", [(np.uint8, 1), (np.uint16, 97), (np.float32, 0.0125)])
@pytest.mark.parametrize("way", ["list", "function"])
def test_arrays_keep_their_samples(city, type, scale, way):
    images, values = samples_of_views(city, type, scale)
    asked = []

    def image(i):
        asked.append(i)
        return images[i]

    scene = city.scene.with_images(images if way == "list" else image, bands=NAMES)
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, scene)
    assert result.bands == NAMES and result.samples[0].dtype == type
    whole = np.flatnonzero(result.tags == 0)
    right = [np.array_equal(shown(result, face), values(result.labels[face]).astype(type)) for face in whole]
    assert np.mean(right) > 0.99  # all but faces thinner than a texel
    if way == "function":
        assert sorted(asked) == sorted(2 * list(range(6)))  # for the range, and to texture


def test_arrays_with_cameras_give_the_same(city, few):
    images, _ = samples_of_views(city, np.uint16, 97)
    a = gpvc.texture(city.mesh.vertices, city.mesh.faces, images, few.K, few.poses, few.lenses, bands=NAMES)
    b = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene.with_images(images, bands=NAMES))
    assert a.bands == b.bands and a.samples[0].dtype == b.samples[0].dtype
    assert (a.samples[0].shape == b.samples[0].shape) and (a.samples[0] == b.samples[0]).mean() > 0.95


@pytest.mark.filterwarnings("ignore::gpvc.GpvcWarning")  # noise fits nothing
def test_one_band_and_what_is_no_number(city):
    rng = np.random.default_rng(3)
    images = [rng.uniform(280, 300, (320, 480)).astype(np.float32) for _ in range(6)]
    for image in images:
        image[:, :200] = np.nan
    scene = city.scene.with_images(images, bands=["Thermal"])
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, scene, allow_misfit=True)
    painted = result.samples[0][result.samples[0] != 0]
    assert painted.min() >= 280 and painted.max() <= 300
    plain = gpvc.coverage(city.mesh.vertices, city.mesh.faces, city.scene)
    masked = gpvc.coverage(city.mesh.vertices, city.mesh.faces, scene)
    assert masked.photos.sum() < 0.8 * plain.photos.sum()


def bad(images):
    return [
        ({"bands": NAMES[:4]}, ValueError, "images[0] has shape (320, 480, 5), expected (H, W, 4)"),
        ({"bands": ["a", "a"]}, ValueError, "bands: expected names that differ"),
        ({"bands": "NIR"}, TypeError, "bands: expected a list of names"),
        ({"bands": []}, ValueError, "bands has 0 names"),
        ({"bands": None}, ValueError, "bands=[...] names more"),
        ({"composite": ["NIR"]}, ValueError, "composite: expected bands, too"),
        ({"bands": NAMES, "composite": ["NIR", "Infrared", "Red"]}, ValueError, "composite: has no band 'Infrared'"),
        ({"bands": NAMES, "images": [i.astype(np.int32) for i in images]}, ValueError, "images[0] has samples of int32"),
        ({"bands": NAMES, "images": images[:3] + [i.astype(np.uint8) for i in images[3:]]}, ValueError,
         "images[3] has samples of uint8, others of uint16: expected one type"),
        ({"bands": NAMES, "images": ["a.tif"] * 6}, ValueError, "images[0] is a path, expected an array of bands"),
    ]


@pytest.mark.parametrize("number", range(10))
def test_bad_arguments(city, number):
    images, _ = samples_of_views(city, np.uint16, 97)
    arguments, kind, sentence = bad(images)[number]
    arguments = {"images": images, **arguments}
    if arguments.get("composite") and not arguments.get("bands"):
        arguments["images"] = city.images
    with pytest.raises(kind) as raised:
        city.scene.with_images(**arguments)
    assert sentence in str(raised.value)


def test_a_scene_has_its_own(city, flight):
    with pytest.raises(ValueError, match="bands: a scene has its own"):
        gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene, bands=NAMES)
    scene = gpvc.read_scene(flight / "colmap", composite=["NIR", "Red", "Green"])
    assert "NIR" in scene.bands
    assert scene.with_images([np.zeros((320, 480, 3), np.uint8)] * 6).bands == []
    with pytest.raises(gpvc.InputError, match="Ultraviolet"):
        gpvc.read_scene(flight / "colmap", composite=["Ultraviolet"])
    assert os.path.exists(flight / "out" / "model_0.tif")
