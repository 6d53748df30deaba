"""Texture coordinates that a mesh has already."""

import os

import numpy as np

from . import _cameras, _gpvc


class Uv:
    """Texture coordinates of a mesh, and the pages that they lie on: from arrays, or by read_uv().

    uv: (F, 3, 2), of each corner of each face, or (V, 2), of each vertex. (0, 0) is a page's upper left corner, (1, 1) the lower
        right one, as in Result.uv. UDIM tiles follow to the right with u beyond 1, and upwards with v below 0.
    page: (F,) whole numbers, the page of each face; -1: it has no texture coordinates. None: all lie on one page.
    sizes: (width, height) of each page, texels; None: as texture(page_size=...) says.
    names: of the pages, as OBJ and glTF call their materials; None: "page_0" and so on.
    """

    def __init__(self, uv, page=None, sizes=None, names=None):
        self.uv = _cameras.numbers(uv, "uv", {"(F, 3, 2)": (None, 3, 2), "(V, 2)": (None, 2)})
        if page is None:
            count = 1
        else:
            page = np.asarray(page)
            if page.ndim != 1 or page.dtype.kind not in "iu":
                raise ValueError(f"page: expected whole numbers of shape (F,), got {page.dtype} of shape {page.shape}")
            if page.min(initial=0) < -1:
                raise ValueError(f"page: {page.min()} is no page, expected -1 or more")
            count = int(page.max(initial=0)) + 1
        self.page = page
        self.sizes = None if sizes is None else [_size(size, i) for i, size in enumerate(sizes)]
        self.names = None if names is None else [str(name) for name in names]
        for name, values in (("sizes", self.sizes), ("names", self.names)):
            if values is not None and len(values) < count:
                raise ValueError(f"{name} has {len(values)} entries, expected one for each of {count} pages")
        self._pages = max(count, len(self.sizes or ()), len(self.names or ()))
        self._core = None

    @classmethod
    def _of_core(cls, core):
        """Of a file, whose numbers stay those that it states."""
        pages = core.pages()
        made = cls.__new__(cls)
        made.uv, made.page = core.uv(), core.page()
        made.sizes = [(width, height) for _, width, height in pages]
        made.names = [name for name, _, _ in pages]
        made._core = core
        return made

    def __repr__(self):
        return f"<gpvc.Uv: {self.uv.shape}>"


def _size(size, i):
    array = np.asarray(size)
    if array.shape != (2,) or array.dtype.kind not in "iu" or array.min() < 1 or array.max() > 32768:
        raise ValueError(f"sizes[{i}]: expected (width, height) of 1 to 32768 texels")
    return int(array[0]), int(array[1])


def read_uv(path):
    """The texture coordinates of an OBJ, PLY, GLB or glTF, for the faces of read_mesh(): a Uv. Its uv is (F, 3, 2), NaN where a face has
    none; a size of (0, 0) is that of a page without a picture."""
    return Uv._of_core(_gpvc.MeshUv.of_file(os.fspath(path)))


def core_of(uv, triangles, vertices):
    """What the module takes, for a mesh of these faces."""
    if uv is None:
        return None
    if not isinstance(uv, Uv):
        uv = Uv(uv)
    if uv._core is not None:
        if uv._core.faces != len(triangles):
            raise ValueError(f"uv has {uv._core.faces} faces, expected {len(triangles)}, those of faces")
        return uv._core
    name, expected = ("(F, 3, 2)", len(triangles)) if uv.uv.ndim == 3 else ("(V, 2)", vertices)
    if len(uv.uv) != expected:
        raise ValueError(f"uv has shape {uv.uv.shape}, expected {name} with {expected} entries, those of the mesh")
    page = np.zeros(len(triangles), np.uint32) if uv.page is None else uv.page
    if len(page) != len(triangles):
        raise ValueError(f"page of uv has {len(page)} entries, expected {len(triangles)}, one for each face")
    names = uv.names or [""] * uv._pages
    pages = [(name, *size) for name, size in zip(names, uv.sizes or [(0, 0)] * uv._pages)]
    return _gpvc.MeshUv.of_arrays(np.ascontiguousarray(uv.uv), triangles, page.astype(np.int64).astype(np.uint32), pages)
