"""Textures a mesh from arrays: python3 texture_arrays.py OUT.glb

The scene is a roof over a square, painted with stripes, and four photos of it that are computed here.
"""

import sys

import numpy as np

import gpvc

WIDTH, HEIGHT, FOCAL = 480, 360, 420.0


def roof():
    """A ridge along y, as a grid of (V, 3) vertices and (F, 3) faces."""
    n = 21
    x, y = np.meshgrid(np.linspace(-4, 4, n), np.linspace(-4, 4, n))
    vertices = np.stack([x, y, 1.5 - 0.5 * np.abs(x)], axis=-1).reshape(-1, 3)
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    lower = np.stack([first, first + 1, first + n + 1], axis=1)
    upper = np.stack([first, first + n + 1, first + n], axis=1)
    return vertices, np.concatenate([lower, upper])


def paint(x, y):
    """The colours of the surface, (..., 3), 0 to 255."""
    waves = [np.sin(4 * x) * np.cos(3 * y), np.sin(5 * x + 2 * y), np.cos(6 * y - x)]
    return 128 + 90 * np.stack(waves, axis=-1)


def photo(pose, K):
    """The roof as a pinhole camera sees it: where the ray of each pixel meets the higher of the two planes."""
    column, row = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)  # centres of pixels
    rays = np.stack([column, row, np.ones_like(row)], axis=-1) @ np.linalg.inv(K).T @ pose[:, :3]
    centre = -pose[:, :3].T @ pose[:, 3]
    nearest = np.full((HEIGHT, WIDTH), np.inf)
    for side in (-1, 1):  # z = 1.5 - side x / 2
        distance = (1.5 - side * centre[0] / 2 - centre[2]) / (rays[..., 2] + side * rays[..., 0] / 2)
        x, y = (centre[:2] + rays[..., :2] * distance[..., None]).transpose(2, 0, 1)
        there = (side * x >= 0) & (np.abs(x) <= 4) & (np.abs(y) <= 4) & (distance > 0)
        nearest = np.where(there & (distance < nearest), distance, nearest)
    seen = np.isfinite(nearest)
    points = centre + rays * np.where(seen, nearest, 0)[..., None]
    return np.where(seen[..., None], paint(points[..., 0], points[..., 1]), 60).astype(np.uint8)


def looking_down_from(x, y, z):
    """camera_from_world, (3, 4): x to the right, y down in the picture, which is the world's -y."""
    rotation = np.diag([1.0, -1.0, -1.0])
    return np.column_stack([rotation, -rotation @ [x, y, z]])


def main(out):
    vertices, faces = roof()
    K = np.array([[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1]])
    poses = [looking_down_from(x, y, 9) for x in (-2, 2) for y in (-1.5, 1.5)]
    images = [photo(pose, K) for pose in poses]
    result = gpvc.texture(vertices, faces, images, K, poses, progress=True, page_size=2048)
    print(f"{len(faces)} faces on {len(result.pages)} pages; photos used: {sorted(set(result.labels.tolist()))}")
    result.save(out)
    return result


if __name__ == "__main__":
    main(sys.argv[1])
