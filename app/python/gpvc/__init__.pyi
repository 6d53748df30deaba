import os
from typing import Any, Callable, Iterator, Mapping, NamedTuple, Protocol, Sequence, Unpack

import numpy as np
import numpy.typing as npt

from ._option_types import TextureOptions, VisibilityOptions

__version__: str

_Path = str | os.PathLike[str]
_Picture = _Path | npt.NDArray[Any]
_Pictures = Sequence[_Picture] | npt.NDArray[Any] | Callable[[int], _Picture]
_Masks = Sequence[_Picture | None] | npt.NDArray[Any] | Callable[[int], _Picture | None]
_Lens = Mapping[str, Any] | Sequence[float] | npt.NDArray[Any]
_Distortion = _Lens | Sequence[_Lens | None]
_Progress = bool | Callable[[str, int, int], None]
_Size = tuple[int, int] | npt.NDArray[Any]

class _Reconstruction(Protocol):
    @property
    def cameras(self) -> Any: ...
    @property
    def images(self) -> Any: ...

class Error(Exception):
    measures: dict[str, float]

class InputError(Error, ValueError): ...
class OutputError(Error, OSError): ...
class GpvcWarning(UserWarning): ...

class View(NamedTuple):
    name: str
    photo: str
    mask: str
    width: int
    height: int
    K: npt.NDArray[np.float64]
    camera_from_world: npt.NDArray[np.float64]
    centre: tuple[float, float, float]
    distortion: dict[str, Any]

class Scene:
    views: list[View]
    @property
    def format(self) -> str: ...
    @property
    def srs(self) -> str: ...
    @property
    def bands(self) -> list[str]: ...
    def with_images(
        self,
        images: _Pictures,
        masks: _Masks | None = None,
        bands: Sequence[str] | None = None,
        composite: Sequence[str] | None = None,
    ) -> Scene: ...

class Mesh(NamedTuple):
    vertices: npt.NDArray[np.float64]
    faces: npt.NDArray[np.uint32]
    source_faces: npt.NDArray[np.uint32]

class Coverage(NamedTuple):
    photos: npt.NDArray[np.uint32]
    gsd: npt.NDArray[np.float32]
    angle: npt.NDArray[np.float32]

class Uv:
    uv: npt.NDArray[np.float64]
    page: npt.NDArray[Any] | None
    sizes: list[tuple[int, int]] | None
    names: list[str] | None
    def __init__(
        self,
        uv: npt.ArrayLike,
        page: npt.ArrayLike | None = None,
        sizes: Sequence[tuple[int, int]] | None = None,
        names: Sequence[str] | None = None,
    ) -> None: ...

class Result:
    uv: npt.NDArray[np.float32]
    page: npt.NDArray[np.int32]
    pages: list[npt.NDArray[np.uint8]]
    page_names: list[str]
    samples: list[npt.NDArray[Any]]
    bands: list[str]
    labels: npt.NDArray[np.int32]
    tags: npt.NDArray[np.uint8]
    report: dict[str, Any]
    def save(self, path: _Path) -> None: ...

def read_scene(
    source: _Path | _Reconstruction,
    images: _Path | None = None,
    masks: _Path | None = None,
    use_masks: bool = True,
    downscale: int = 1,
    skip_bad_photos: bool = False,
    bands: Mapping[str, _Path] | bool | None = None,
    composite: Sequence[str | int] | None = None,
) -> Scene: ...
def read_mesh(path: _Path) -> Mesh: ...
def read_uv(path: _Path) -> Uv: ...
def texture(
    vertices: npt.ArrayLike,
    faces: npt.ArrayLike,
    images: _Pictures | Scene | _Path | _Reconstruction,
    K: npt.ArrayLike | None = None,
    camera_from_world: npt.ArrayLike | None = None,
    distortion: _Distortion | None = None,
    masks: _Masks | None = None,
    *,
    image_size: _Size | None = None,
    views: Sequence[int | str] | None = None,
    bands: Sequence[str] | None = None,
    composite: Sequence[str] | None = None,
    uv: npt.ArrayLike | Uv | None = None,
    allow: Sequence[tuple[npt.ArrayLike, Sequence[int | str]]] | None = None,
    forbid: Sequence[tuple[npt.ArrayLike, Sequence[int | str]]] | None = None,
    mesh_crs: str | None = None,
    progress: _Progress | None = None,
    threads: int = 0,
    device: int | None = None,
    **options: Unpack[TextureOptions],
) -> Result: ...
def visibility(
    vertices: npt.ArrayLike,
    faces: npt.ArrayLike,
    images: _Pictures | Scene | _Path | _Reconstruction | None,
    K: npt.ArrayLike | None = None,
    camera_from_world: npt.ArrayLike | None = None,
    distortion: _Distortion | None = None,
    masks: _Masks | None = None,
    *,
    image_size: _Size | None = None,
    mesh_crs: str | None = None,
    device: int | None = None,
    **options: Unpack[VisibilityOptions],
) -> Iterator[npt.NDArray[np.uint8]]: ...
def face_ids(
    vertices: npt.ArrayLike,
    faces: npt.ArrayLike,
    images: _Pictures | Scene | _Path | _Reconstruction | None,
    K: npt.ArrayLike | None = None,
    camera_from_world: npt.ArrayLike | None = None,
    distortion: _Distortion | None = None,
    masks: _Masks | None = None,
    *,
    image_size: _Size | None = None,
    mesh_crs: str | None = None,
    of_photo: bool = False,
    device: int | None = None,
    **options: Unpack[VisibilityOptions],
) -> Iterator[npt.NDArray[np.int32]]: ...
def coverage(
    vertices: npt.ArrayLike,
    faces: npt.ArrayLike,
    images: _Pictures | Scene | _Path | _Reconstruction | None,
    K: npt.ArrayLike | None = None,
    camera_from_world: npt.ArrayLike | None = None,
    distortion: _Distortion | None = None,
    masks: _Masks | None = None,
    *,
    image_size: _Size | None = None,
    mesh_crs: str | None = None,
    progress: _Progress | None = None,
    device: int | None = None,
    **options: Unpack[VisibilityOptions],
) -> Coverage: ...
def evaluate(
    model: _Path | Result,
    images: _Pictures | Scene | _Path | _Reconstruction,
    K: npt.ArrayLike | None = None,
    camera_from_world: npt.ArrayLike | None = None,
    distortion: _Distortion | None = None,
    masks: _Masks | None = None,
    *,
    image_size: _Size | None = None,
    views: Sequence[int | str] | None = None,
    reduction: int = 4,
    output: _Path | None = None,
    progress: _Progress | None = None,
) -> dict[str, Any]: ...
