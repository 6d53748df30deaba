"""A small synthetic city, textured by the program, whose files the module's are held against."""

import os
import pathlib
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest

import gpvc

PROGRAM = os.environ["GPVC_PROGRAM"]
EXAMPLES = pathlib.Path(os.environ["GPVC_EXAMPLES"])


def run_program(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def pictures_of(scene):
    """The photos as arrays, without a library of images: the module decodes them."""
    return [gpvc._gpvc.read_photo(view.photo, "")[0] for view in scene.views]


def same_files(expected, written, names):
    for name in names:
        assert (expected / name).read_bytes() == (written / name).read_bytes(), name


@pytest.fixture(scope="session")
def city(tmp_path_factory):
    folder = tmp_path_factory.mktemp("city")
    run_program("synth", "city", "-o", folder, "--force", "--faces", 6000, "--size", 50, "--photos", 6, "--photo-size", "480x320")
    run_program("texture", folder / "colmap", folder / "mesh.ply", "-o", folder / "out")
    scene, mesh = gpvc.read_scene(folder / "colmap"), gpvc.read_mesh(folder / "mesh.ply")
    return SimpleNamespace(folder=folder, out=folder / "out", scene=scene, mesh=mesh, images=pictures_of(scene))


@pytest.fixture
def few(city):
    """Cameras of the city as arrays: K, camera_from_world, distortion."""
    views = city.scene.views
    return SimpleNamespace(
        K=np.stack([view.K for view in views]),
        poses=np.stack([view.camera_from_world for view in views]),
        lenses=[view.distortion for view in views],
    )
