"""What is installed, from an empty folder."""

import os
import subprocess
import sys

import pytest

import gpvc

PROGRAM = """
import sys, gpvc
mesh, scene = gpvc.read_mesh(sys.argv[1] + "/mesh.ply"), gpvc.read_scene(sys.argv[1] + "/colmap")
gpvc.texture(mesh.vertices, mesh.faces, scene).save(sys.argv[2])
print(gpvc.__file__)
"""


@pytest.mark.parametrize("below", ["local", "usr"])
def test_it_works_where_it_was_installed(city, tmp_path, below):
    """Of a Debian package, below /usr, in the folder of all versions of Python."""
    prefix = tmp_path / below
    subprocess.run(
        ["cmake", "--install", os.environ["GPVC_BUILD"], "--prefix", prefix, "--component", "python"], check=True, capture_output=True
    )
    (package,) = prefix.glob("lib/python*/*-packages/gpvc")
    if package.parent.name == "dist-packages":
        assert package.parent.parent.name == ("python3" if below == "usr" else f"python3.{sys.version_info.minor}")
    names = {path.name for path in package.iterdir()}
    assert {"__init__.py", "__init__.pyi", "_option_types.pyi", "py.typed"} <= names
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, city.folder, tmp_path / "model.glb"], capture_output=True, text=True,
        env={"PYTHONPATH": str(package.parent), "PATH": os.environ["PATH"]},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(package / "__init__.py")
    assert (tmp_path / "model.glb").read_bytes() == (city.out / "model.glb").read_bytes()


def test_the_types_name_what_there_is():
    """The stub has the functions of the package with their arguments, and the options of the library."""
    import ast
    import inspect
    import pathlib

    folder = pathlib.Path(gpvc.__file__).parent
    stub = ast.parse((folder / "__init__.pyi").read_text())
    functions = {node.name: node.args for node in stub.body if isinstance(node, ast.FunctionDef)}
    classes = {node.name for node in stub.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")}
    assert classes | set(functions) == set(gpvc.__all__) - {"__version__"}
    for name, arguments in functions.items():
        parameters = inspect.signature(getattr(gpvc, name)).parameters
        named = [a.arg for a in (*arguments.args, *arguments.kwonlyargs, *([arguments.kwarg] if arguments.kwarg else []))]
        assert named == list(parameters), name
    types = ast.parse((folder / "_option_types.pyi").read_text())
    options = {node.name: [field.target.id for field in node.body] for node in types.body if isinstance(node, ast.ClassDef)}
    assert options["TextureOptions"] == [entry["name"] for entry in gpvc._gpvc.texture_options()]
    assert "page_size" in gpvc.texture.__doc__ and "subpixel" in gpvc.visibility.__doc__
