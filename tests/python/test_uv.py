"""Texture coordinates that a mesh has: the same bytes as `gpvc texture --keep-uv`."""

import os

import numpy as np
import pytest

import gpvc
from conftest import run_program, same_files

# On pages smaller than those that the charts were made for, neighbours share texels.
pytestmark = pytest.mark.filterwarnings("ignore:.*(lie under several|in a line or a point|have no texture coordinates)")


@pytest.fixture(scope="module")
def kept(city):
    """The city's model, baked by the program onto its own texture coordinates."""
    folder = city.folder / "kept"
    run_program("texture", city.folder / "colmap", city.out / "model.obj", "-o", folder, "--keep-uv", "--page-size", 512)
    return folder


def texture(city, uv, **options):
    return gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene, uv=uv, **options)


def test_bytes_of_the_program(city, kept, tmp_path):
    mesh = gpvc.read_mesh(city.out / "model.obj")
    result = gpvc.texture(mesh.vertices, mesh.faces, city.scene, uv=gpvc.read_uv(city.out / "model.obj"), page_size=512)
    result.save(tmp_path / "model.obj")
    result.save(tmp_path / "model.glb")
    result.save(tmp_path / "whole")
    files = ["model.obj", "model.mtl", "model_0.jpg", "model.glb"]
    same_files(kept, tmp_path, files)
    same_files(kept, tmp_path / "whole", [*files, "labels.npy"])
    assert result.page_names == ["_0"]


def test_arrays_give_the_same_pages(city, kept, tmp_path):
    uv = gpvc.read_uv(city.out / "model.obj")
    assert uv.uv.shape == (len(city.mesh.faces), 3, 2)
    result = texture(city, gpvc.Uv(uv.uv, sizes=uv.sizes), page_size=512, texture="png")
    from_file = texture(city, uv, page_size=512, texture="png")
    assert (result.pages[0] == from_file.pages[0]).all()
    assert np.abs(result.uv - uv.uv).max() < 1e-6
    # Corners of a vertex at one place share it: as many vertices as of the file.
    for name, made in (("a", result), ("b", from_file)):
        made.save(tmp_path / (name + ".glb"))
    assert os.path.getsize(tmp_path / "a.glb") == os.path.getsize(tmp_path / "b.glb")


def test_a_result_again(city):
    first = texture(city, None, max_texels=100_000, page_size=256)
    assert len(first.pages) > 1
    sizes = [(page.shape[1], page.shape[0]) for page in first.pages]
    names = [f"roof {n}" for n in range(len(sizes))]
    again = texture(city, gpvc.Uv(first.uv, first.page, sizes, names))
    assert (again.page == first.page).all()
    assert (again.uv == first.uv).all()
    assert [page.shape for page in again.pages] == [page.shape for page in first.pages]
    assert again.page_names == ["_" + name.replace(" ", "_") for name in names]
    assert (again.labels == first.labels).all()


def test_of_vertices_with_tiles_and_bare_faces(city, tmp_path):
    # From above, the right half in the second tile.
    at = city.mesh.vertices[:, :2]
    uv = (at - at.min(axis=0)) / np.ptp(at, axis=0)
    tile = uv[city.mesh.faces, 0].mean(axis=1) > 0.5
    corners = uv[city.mesh.faces] * [0.4, 1] + np.where(tile, 1.0, 0.0)[:, None, None] * [1, 0]
    page = np.zeros(len(tile), int)
    page[7] = -1
    result = texture(city, gpvc.Uv(corners, page), page_size=256)
    assert result.page_names == [".1001", ".1002"]
    assert result.page[7] == -1 and (np.delete(result.page, 7) == np.delete(tile, 7)).all()
    result.save(tmp_path / "flat.obj")
    assert sorted(os.listdir(tmp_path)) == ["flat.1001.jpg", "flat.1002.jpg", "flat.mtl", "flat.obj"]
    by_vertex = texture(city, uv, page_size=256)
    assert [page.shape for page in by_vertex.pages] == [(256, 256, 3)]
    with pytest.raises(gpvc.InputError, match="vertices, faces, uv: texture coordinates: overlap"):
        texture(city, np.zeros_like(uv) + uv[:, :1] * [1, 0.5] + uv[:, 1:] * [0, 0.1], overlap="refuse")


def bad_arguments(city):
    uv = np.zeros((len(city.mesh.faces), 3, 2))
    broken = uv.copy()
    broken[3, 1, 0] = np.nan
    across = uv.copy()
    across[5] = [[0.5, 0.5], [1.5, 0.5], [0.5, 0.7]]
    return [
        (broken, "uv[3, 1, 0] is nan, expected finite numbers"),
        (uv[:, 0], f"uv has shape ({len(uv)}, 2), expected (V, 2) with {len(city.mesh.vertices)} entries"),
        (uv[:9], f"uv has shape (9, 3, 2), expected (F, 3, 2) with {len(uv)} entries"),
        (uv[..., 0], f"uv has shape ({len(uv)}, 3), expected (F, 3, 2) or (V, 2)"),
        ("model.obj", "uv: expected an array of numbers"),
        (uv, "vertices, faces, uv: has no texture coordinates"),
        (across, "uv: face 5: has the texture coordinates u = 0.5 to 1.5"),
    ]


@pytest.mark.parametrize("number", range(7))
def test_bad_arguments(city, number):
    uv, sentence = bad_arguments(city)[number]
    with pytest.raises(ValueError) as raised:
        texture(city, uv)
    assert sentence in str(raised.value)


@pytest.mark.parametrize("arguments, sentence", [
    ({"page": [0.5]}, "page: expected whole numbers"),
    ({"page": [-2, 0]}, "page: -2 is no page"),
    ({"page": [0, 2], "sizes": [(8, 8)]}, "sizes has 1 entries, expected one for each of 3 pages"),
    ({"sizes": [(8, 0)]}, "sizes[0]: expected (width, height)"),
    ({"page": [1, 0], "names": ["a"]}, "names has 1 entries"),
])
def test_bad_pages(arguments, sentence):
    with pytest.raises(ValueError) as raised:
        gpvc.Uv(np.zeros((2, 3, 2)), **arguments)
    assert sentence in str(raised.value)


def test_pages_of_another_mesh(city):
    with pytest.raises(ValueError, match="page of uv has 2 entries"):
        texture(city, gpvc.Uv(np.zeros((len(city.mesh.faces), 3, 2)), [0, 0]))
