"""The same bytes as the program's, whatever the photos come as."""

import os

import numpy as np
import pytest

import gpvc
from conftest import run_program, same_files

MODEL = ["model.glb", "model.obj", "model.mtl", "model_0.jpg"]


def save_and_compare(city, result, folder):
    result.save(folder / "model.glb")
    result.save(folder / "model.obj")
    assert sorted(os.listdir(folder)) == sorted(MODEL)
    same_files(city.out, folder, MODEL)
    assert (result.labels == np.load(city.out / "labels.npy")).all()
    assert (result.tags == np.load(city.out / "tags.npy")).all()


def test_from_a_path(city, tmp_path):
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.folder / "colmap")
    save_and_compare(city, result, tmp_path)


def test_from_arrays(city, tmp_path):
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene.with_images(city.images))
    save_and_compare(city, result, tmp_path)


def test_from_a_function_that_is_asked_once_for_each_image(city, tmp_path):
    asked = []

    def image(i):
        asked.append(i)
        return city.images[i]

    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene.with_images(image))
    save_and_compare(city, result, tmp_path)
    assert sorted(asked) == list(range(6))
    assert result.report["counts"]["decodes"]["all"] == 6


def test_from_deep_grey_unordered_and_mixed_arrays(city, tmp_path):
    def deep(i):
        rgb = city.images[i]
        frozen = rgb.copy()
        frozen.flags.writeable = False
        return [
            rgb.astype(np.uint16) * 257,
            rgb.astype(np.float32) / 255,
            rgb.astype(np.float64) / 255,
            np.asfortranarray(rgb),
            frozen,
            city.scene.views[i].photo,
        ][i]

    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene.with_images(deep))
    save_and_compare(city, result, tmp_path)
    listed = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene.with_images([deep(i) for i in range(6)]))
    (tmp_path / "listed").mkdir()
    save_and_compare(city, listed, tmp_path / "listed")


def test_meshes_of_other_types_and_orders(city, tmp_path):
    vertices = np.asfortranarray(city.mesh.vertices)
    faces = city.mesh.faces.astype(np.int64)[::-1][::-1]
    result = gpvc.texture(vertices.tolist(), faces, city.scene)
    save_and_compare(city, result, tmp_path)


def test_a_folder_has_what_the_program_writes(city, tmp_path):
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene)
    result.save(tmp_path / "out")
    names = sorted(os.listdir(tmp_path / "out"))
    assert set(names) == set(os.listdir(city.out)) - {"run.json", "views.json"}
    same_files(city.out, tmp_path / "out", names)
    with pytest.raises(gpvc.OutputError, match="choose another path"):
        result.save(tmp_path / "out")


@pytest.mark.parametrize(
    "options, flags",
    [
        ({"page_size": 512, "texture": "png", "normals": True, "seams": "global"},
         ["--page-size", "512", "--texture", "png", "--normals", "--seams", "global"]),
        ({"target": "web", "max_bytes": "200k", "jpeg_fallback": False}, ["--target", "web", "--max-bytes", "200k", "--no-jpeg-fallback"]),
        ({"unseen": "color", "unseen_color": (9, 8, 7), "blend": "none", "memory": 10**9},
         ["--unseen", "color", "--unseen-color", "9,8,7", "--blend", "none", "--memory", "1G"]),
    ],
)
def test_options_do_what_the_programs_do(city, tmp_path, options, flags):
    run_program("texture", city.folder / "colmap", city.folder / "mesh.ply", "-o", tmp_path / "out", *flags)
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene, **options)
    (tmp_path / "made").mkdir()
    result.save(tmp_path / "made" / "model.glb")
    result.save(tmp_path / "made" / "model.obj")
    same_files(tmp_path / "out", tmp_path / "made", os.listdir(tmp_path / "made"))


def test_views_are_those_of_a_list(city, tmp_path):
    run_program("texture", city.folder / "colmap", city.folder / "mesh.ply", "-o", tmp_path / "out", "--views", "nadir*,east*")
    names = [view.name for view in city.scene.views if view.name.startswith(("nadir", "east"))]
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene, views=names)
    result.save(tmp_path / "model.glb")
    same_files(tmp_path / "out", tmp_path, ["model.glb"])
    numbers = [i for i, view in enumerate(city.scene.views) if view.name in names]
    assert set(result.labels.tolist()) <= {-1, *numbers}


def test_gltf_with_files(city, tmp_path):
    run_program("texture", city.folder / "colmap", city.folder / "mesh.ply", "-o", tmp_path / "out", "--gltf", "files")
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene)
    (tmp_path / "made").mkdir()
    result.save(tmp_path / "made" / "model.gltf")
    same_files(tmp_path / "out", tmp_path / "made", ["model.gltf", "model.bin", "model_0.jpg"])


def test_another_name_is_that_of_all_files(city, tmp_path):
    gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene).save(tmp_path / "a house.obj")
    assert sorted(os.listdir(tmp_path)) == ["a house.mtl", "a house.obj", "a house_0.jpg"]
    assert "mtllib a house.mtl" in (tmp_path / "a house.obj").read_text()


def test_cameras_as_arrays_see_the_same(city, few):
    """All but a few texels in a thousand: a translation states a camera's centre up to its last digit."""
    by_scene = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene)
    for images in (city.images, [view.photo for view in city.scene.views], city.images.__getitem__):
        for K, poses in ((few.K, few.poses), (few.K[0], np.pad(few.poses, ((0, 0), (0, 1), (0, 0))))):
            if poses.shape[1] == 4:
                poses[:, 3, 3] = 1
            result = gpvc.texture(city.mesh.vertices, city.mesh.faces, images, K, poses, few.lenses)
            assert (result.labels == by_scene.labels).all()
            assert (result.uv == by_scene.uv).all()
            off = np.abs(result.pages[0].astype(int) - by_scene.pages[0])
            assert (off > 0).mean() < 3e-3


def test_opencvs_coefficients_are_the_terms_of_their_names(city, few):
    cv = np.array([[lens.get(term, 0.0) for term in ("k1", "k2", "p1", "p2", "k3")] for lens in few.lenses])
    one = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.images, few.K, few.poses, few.lenses)
    for distortion in (cv, cv[0], cv[0, :4], list(cv)):
        other = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.images, few.K, few.poses, distortion)
        assert (one.pages[0] == other.pages[0]).all()


def test_the_result_shows_the_photos(city):
    """Each face that is seen whole has, in its middle, a colour like its photo's."""
    r = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene, seams="none", blend="none", align="none", unseen="drop")
    page, middle = r.pages[0], r.uv.mean(axis=1)
    height, width = page.shape[:2]
    texels = page[(middle[:, 1] * height).astype(int).clip(0, height - 1), (middle[:, 0] * width).astype(int).clip(0, width - 1)]
    errors = []
    for i, view in enumerate(city.scene.views):
        shown = np.flatnonzero((r.labels == i) & (r.tags == 0))
        points = city.mesh.vertices[city.mesh.faces[shown]].mean(axis=1)
        p = points @ view.camera_from_world[:, :3].T + view.camera_from_world[:, 3]
        x, y = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
        d, r2 = view.distortion, x * x + y * y
        radial = 1 + d["k1"] * r2 + d["k2"] * r2**2
        u = view.K[0, 0] * (x * radial + 2 * d["p1"] * x * y + d["p2"] * (r2 + 2 * x * x)) + view.K[0, 2]
        v = view.K[1, 1] * (y * radial + d["p1"] * (r2 + 2 * y * y) + 2 * d["p2"] * x * y) + view.K[1, 2]
        photo = city.images[i][v.astype(int).clip(0, view.height - 1), u.astype(int).clip(0, view.width - 1)]
        errors.append(np.abs(photo.astype(int) - texels[shown]).mean(axis=1))
    errors = np.concatenate(errors)
    assert len(errors) > 2000 and np.median(errors) < 6 and np.mean(errors) < 12, (len(errors), np.median(errors), errors.mean())


def test_arrays_of_a_result(city):
    r = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene, unseen="drop")
    faces = len(city.mesh.faces)
    assert r.uv.shape == (faces, 3, 2) and r.uv.dtype == np.float32 and ((r.uv >= 0) & (r.uv <= 1)).all()
    assert r.page.shape == r.labels.shape == r.tags.shape == (faces,)
    assert r.page.max() == len(r.pages) - 1 and r.page.dtype == r.labels.dtype == np.int32
    assert all(page.dtype == np.uint8 and page.ndim == 3 and not page.flags.writeable for page in r.pages)
    assert [stage["name"] for stage in r.report["stages"]][:4] == ["read", "face graph", "see", "choose"]
    pages = r.pages
    del r
    assert pages[0].sum() > 0  # they keep what they lie in


def test_masks_and_alphas_exclude(city):
    left = np.zeros((320, 480), bool)
    left[:, :240] = True
    rgba = [np.dstack([image, np.where(left, 255, 0).astype(np.uint8)]) for image in city.images]
    results = [
        gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene.with_images(images, masks))
        for images, masks in [
            (city.images, [left] * 6),
            (city.images, [left.astype(np.uint8)] * 6),
            (city.images, lambda i: np.where(left, 255, 100).astype(np.uint8)),
            (lambda i: rgba[i], None),
            (rgba, [None] * 6),
        ]
    ]
    whole = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene)
    assert (results[0].labels != whole.labels).any()
    for other in results[1:]:
        assert (other.labels == results[0].labels).all() and (other.pages[0] == results[0].pages[0]).all()


def test_contiguous_photos_are_borrowed(city):
    from gpvc._pictures import Pictures

    pictures = Pictures(city.images, None, [(480, 320)] * 6)
    assert pictures.picture(2)[0] is city.images[2]
    before = [image.copy() for image in city.images]
    gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene.with_images(city.images, [np.ones((320, 480), bool)] * 6))
    assert all((a == b).all() for a, b in zip(before, city.images))


def test_evaluate_says_what_the_program_says(city, tmp_path):
    import json

    run_program("evaluate", city.out / "model.glb", city.folder / "colmap", "-o", tmp_path / "scores")
    said = json.loads((tmp_path / "scores" / "evaluate.json").read_text())
    assert gpvc.evaluate(city.out / "model.glb", city.scene)["mean"] == said["mean"]
    result = gpvc.texture(city.mesh.vertices, city.mesh.faces, city.scene)
    mine = gpvc.evaluate(result, city.scene.with_images(city.images))
    assert list(mine["views"]) == list(said["views"])
    assert mine["mean"]["psnr_db"] > said["mean"]["psnr_db"] - 0.01  # pages without the loss of a JPEG
