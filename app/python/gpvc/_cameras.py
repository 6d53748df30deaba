"""Cameras and poses from arrays, and from objects with pycolmap's attributes."""

import os
import pathlib
import shutil
import tempfile
import weakref

import numpy as np

# OpenCV's coefficients in their order, by the names of the library's terms.
_OPENCV = ("k1", "k2", "p1", "p2", "k3", "d1", "d2", "d3", "s1", "s3", "s2", "s4")


def numbers(value, name, shapes):
    """A float64 array of one of these shapes, whose numbers are finite. `shapes` are texts such as "(N, 3, 4)", for the message,
    with the tuple of each; None is any size."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected an array of numbers, of shape {' or '.join(shapes)}") from None
    fits = any(
        array.ndim == len(shape) and all(n is None or n == m for n, m in zip(shape, array.shape)) for shape in shapes.values()
    )
    if not fits:
        raise ValueError(f"{name} has shape {array.shape}, expected {' or '.join(shapes)}")
    if not np.isfinite(array).all():
        at = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name}{list(at)} is {array[at]}, expected finite numbers")
    return array


def intrinsics(K, count):
    """(N, 4): fx, fy, cx, cy."""
    K = numbers(K, "K", {"(3, 3)": (3, 3), f"({count}, 3, 3)": (count, 3, 3)})
    K = np.broadcast_to(K, (count, 3, 3))
    expected = np.zeros_like(K)
    expected[:, 2, 2] = 1
    for row, column in ((0, 0), (1, 1), (0, 2), (1, 2)):
        expected[:, row, column] = K[:, row, column]
    wrong = np.argwhere(K != expected)
    if len(wrong):
        _, row, column = (int(i) for i in wrong[0])
        raise ValueError(
            f"K: expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], and row {row}, column {column} is {K[tuple(wrong[0])]:g}"
            + ("; a skew is distortion={'model': 'perspective', 'skew': ...}" if (row, column) == (0, 1) else "")
        )
    if not (K[:, [0, 1], [0, 1]] > 0).all():
        raise ValueError("K: expected focal lengths above 0")
    return np.ascontiguousarray(np.stack([K[:, 0, 0], K[:, 1, 1], K[:, 0, 2], K[:, 1, 2]], axis=1))


def poses(camera_from_world):
    """Rotations (N, 3, 3) and translations (N, 3)."""
    name = "camera_from_world"
    matrices = numbers(camera_from_world, name, {"(N, 3, 4)": (None, 3, 4), "(N, 4, 4)": (None, 4, 4)})
    if len(matrices) == 0:
        raise ValueError(f"{name} has no poses, expected at least one")
    if matrices.shape[1] == 4:
        wrong = np.argwhere(matrices[:, 3] != [0, 0, 0, 1])
        if len(wrong):
            raise ValueError(f"{name}[{wrong[0][0]}] has the last row {matrices[wrong[0][0], 3]}, expected [0, 0, 0, 1]")
    rotations = np.ascontiguousarray(matrices[:, :3, :3])
    for i, rotation in enumerate(rotations):
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-4 or np.linalg.det(rotation) < 0:
            raise ValueError(f"{name}[{i}] has no rotation in its first three columns (orthonormal, without mirroring)")
    return rotations, np.ascontiguousarray(matrices[:, :3, 3])


def _lens(value, name):
    if value is None:
        return "opencv", {}
    if isinstance(value, dict):
        terms = dict(value)
        model = terms.pop("model", "opencv")
        return model, {term: float(numbers(x, f"{name}[{term!r}]", {"()": ()})) for term, x in terms.items()}
    terms = numbers(value, name, {"(4,)": (4,), "(5,)": (5,), "(8,)": (8,), "(12,)": (12,)})
    return ("opencv" if len(terms) <= 5 else "perspective"), {n: float(x) for n, x in zip(_OPENCV, terms)}


def lenses(distortion, count):
    """A list of (model, terms)."""
    one = distortion is None or isinstance(distortion, dict)
    if not one and not (hasattr(distortion, "__len__") and len(distortion) > 0):
        raise ValueError("distortion: expected OpenCV's coefficients, a dict, or one of these for each image")
    if not one and not isinstance(distortion[0], dict) and distortion[0] is not None:
        one = np.ndim(distortion[0]) == 0
    if one:
        return [_lens(distortion, "distortion")] * count
    if len(distortion) != count:
        raise ValueError(f"distortion has {len(distortion)} entries, expected one for each of {count} images")
    return [_lens(each, f"distortion[{i}]") for i, each in enumerate(distortion)]


def is_reconstruction(value):
    return hasattr(value, "cameras") and hasattr(value, "images")


def _called(value):
    return value() if callable(value) else value


def _quaternion(rotation):
    """w, x, y, z of a rotation with pycolmap's attributes: quat (x, y, z, w), or matrix()."""
    if hasattr(rotation, "quat"):
        x, y, z, w = (float(c) for c in np.asarray(_called(rotation.quat)).ravel())
        return w, x, y, z
    m = numbers(_called(rotation.matrix), "cam_from_world.rotation", {"(3, 3)": (3, 3)})
    # The largest of the four first (Shepperd 1978): a row of the products of each two of them, times 4.
    w, x, y, z = 1 + np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) @ np.diag(m)
    off = m - m.T
    wx, wy, wz = off[2, 1], off[0, 2], off[1, 0]
    xy, xz, yz = m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
    products = np.array([[w, wx, wy, wz], [wx, x, xy, xz], [wy, xy, y, yz], [wz, xz, yz, z]])
    largest = int(np.argmax(np.diag(products)))
    return tuple((products[largest] / (2 * np.sqrt(products[largest, largest]))).tolist())


def _model_name(camera):
    name = getattr(camera, "model_name", None)
    if name is None:
        name = getattr(camera.model, "name", camera.model)
    return str(name)


def write_colmap(reconstruction, folder):
    """The cameras and images of an object with pycolmap's attributes as a COLMAP text model, whose numbers read back exactly."""
    with open(os.path.join(folder, "cameras.txt"), "w", encoding="utf-8") as file:
        for number, camera in reconstruction.cameras.items():
            params = " ".join(repr(float(p)) for p in camera.params)
            file.write(f"{number} {_model_name(camera)} {int(camera.width)} {int(camera.height)} {params}\n")
    with open(os.path.join(folder, "images.txt"), "w", encoding="utf-8") as file:
        for number, image in reconstruction.images.items():
            if not _called(getattr(image, "has_pose", True)):
                continue
            pose = _called(image.cam_from_world)
            values = [*_quaternion(pose.rotation), *(float(t) for t in np.asarray(pose.translation).ravel())]
            file.write(f"{number} {' '.join(map(repr, values))} {image.camera_id} {image.name}\n\n")
    pathlib.Path(folder, "points3D.txt").touch()


class Folder:
    """A folder for temporary files that is removed with this object, and quietly."""

    def __init__(self):
        self.name = tempfile.mkdtemp(prefix="gpvc-")
        weakref.finalize(self, shutil.rmtree, self.name, ignore_errors=True)
