"""Which photos may texture a face: the rules of `gpvc texture --allow`."""

import numpy as np
import pytest

import gpvc
from conftest import run_program, same_files


def texture(city, **rules):
    return gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene, **rules)


@pytest.mark.filterwarnings("ignore:.*the rules refuse all photos")
def test_rules_are_those_of_the_program(city, tmp_path):
    first = texture(city)
    view = int(np.bincount(first.labels[first.labels >= 0]).argmax())
    name = city.scene.views[view].name
    faces = np.arange(500, 2500)
    (tmp_path / "rules.json").write_text(
        '{"rules": [{"faces": [[500, 2499]], "forbid": ["%s"]}]}' % name)
    run_program("texture", city.folder / "colmap", city.folder / "mesh.ply", "-o", tmp_path / "out", "--allow", tmp_path / "rules.json")
    result = texture(city, forbid=[(faces, [name])])
    result.save(tmp_path / "whole")
    same_files(tmp_path / "out", tmp_path / "whole", ["model.glb", "model.obj", "model_0.jpg", "labels.npy"])
    assert (result.labels[faces] != view).all() and (first.labels[faces] == view).any()
    other = (view + 1) % 6
    mask = np.zeros(len(city.mesh.faces), bool)
    mask[faces] = True
    with pytest.warns(gpvc.GpvcWarning, match="the rules refuse all photos that see them"):
        alone = texture(city, allow=[(mask, [other])])
    assert np.isin(alone.labels[faces], [-1, other]).all()


@pytest.mark.parametrize("rules, sentence", [
    ({"allow": [([7], [99])]}, "allow[0]: views: 99 is no index"),
    ({"forbid": [([-1], [0])]}, "forbid[0]: there is no face -1"),
    ({"forbid": [([0], [0]), ([10**6], [0])]}, "forbid[1]: there is no face 1000000"),
    ({"allow": [([], [0])]}, "allow[0]: expected (F,) bool or numbers of faces, at least one"),
    ({"allow": [(np.ones(5, bool), [0])]}, "allow[0]: its faces have shape (5,)"),
    ({"allow": [7]}, "allow[0]: expected a pair"),
])
def test_bad_rules(city, rules, sentence):
    with pytest.raises(ValueError) as raised:
        texture(city, **rules)
    assert sentence in str(raised.value)
