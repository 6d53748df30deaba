"""Photo texture for triangle meshes from calibrated photos, and which faces photos see.

Conventions, of all functions:

- A mesh is `vertices` (V, 3), float64, in any units, and `faces` (F, 3), whole numbers, counter-clockwise seen from outside.
- `camera_from_world` (N, 3, 4) or (N, 4, 4) takes points of the world to a camera that looks along +z, x right, y down (OpenCV's
  axes): x_camera = R x_world + t.
- `K` is (3, 3), or (N, 3, 3) with one for each image, in pixels. Pixel coordinates begin at the upper left corner of the image, so
  that the first pixel's centre is (0.5, 0.5), as in COLMAP; OpenCV has it at (0, 0): add 0.5 to the principal point of its
  calibrations.
- `distortion` is None, OpenCV's coefficients k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4]]], or a dict with a "model" ("opencv",
  "perspective", "equidistant" (OpenCV's fisheye), "fov", ...) and its terms; one for all images, or a list with one for each.
- `images` is a sequence of paths and of arrays (H, W) or (H, W, C) of uint8, uint16 or float (0 to 1), or a function of an index that
  gives one of these. Alphas of 0 exclude pixels. A C-contiguous (H, W, 3) array of uint8 is used where it lies and must not change
  during a call. A function is called from several threads, for one index by one at a time, and again only where its image was
  needed later and did not fit into memory meanwhile.
- `bands`, a list of names, says that images are (H, W, len(bands)) of uint8, uint16 or float32 whose samples are kept as they are:
  Result.samples has them beside the pages, which show a composite of 8 bits (`composite`: the names of red, green and blue, or of a grey
  one). NaN excludes a pixel. Up to eight images are asked for beforehand, for the composite's range.
- `masks` likewise, (H, W): what is False, black or darker than half is not used.
- In the place of `images`, with neither K nor camera_from_world: a Scene, the path of one in any format that `gpvc` reads, or an
  object with pycolmap's attributes (Reconstruction).

Calls release the interpreter's lock, stop at Ctrl-C within a second and may run in several threads. `progress` is True (tqdm, where
it is installed), or a function of (stage, done, total).
"""

import json
import os
import warnings as _warnings
from typing import NamedTuple

import numpy as np

from . import _cameras, _gpvc, _options, _pictures, _uv
from ._errors import Error, GpvcWarning, InputError, OutputError
from ._gpvc import __version__
from ._progress import Progress as _Progress
from ._uv import Uv, read_uv

__all__ = [
    "Coverage", "Error", "GpvcWarning", "InputError", "Mesh", "OutputError", "Result", "Scene", "Uv", "View", "coverage",
    "evaluate", "face_ids", "read_mesh", "read_scene", "read_uv", "texture", "visibility", "__version__",
]


class View(NamedTuple):
    """A camera of a scene. Of panoramas and wide fisheyes, one of several that show a photo."""

    name: str  #: as the scene names it, unique
    photo: str  #: path of the photo; empty where it is in memory
    mask: str  #: path of the mask; empty where there is none
    width: int  #: pixels
    height: int
    K: np.ndarray  #: (3, 3), of the frame without distortion
    camera_from_world: np.ndarray  #: (3, 4)
    centre: tuple  #: of the camera, in the world
    distortion: dict  #: "model" and the terms that are not 0


class Scene:
    """Cameras and photos. `views` lists the cameras, in the order of the labels of a result."""

    def __init__(self, core, files=None):
        self._core = core
        self._files = files  # a folder that is there as long as the scene
        self.views = [View(**view) for view in core.views()]

    @property
    def format(self):
        """Which reader read it: "COLMAP"."""
        return self._core.format

    @property
    def srs(self):
        """The reference system of the coordinates as the scene states it; empty where it states none."""
        return self._core.srs

    @property
    def bands(self):
        """Names of the bands of the photos; empty where they are RGB or grey of 8 bits."""
        return self._core.bands

    def with_images(self, images, masks=None, bands=None, composite=None):
        """The same cameras with other photos, one for each of `views`, each of its view's size: see `images`, `masks` and `bands` of
        the module."""
        names = _band_names(bands, composite)
        pictures = _pictures_for(images, masks, [(view.width, view.height) for view in self.views], len(names))
        return Scene(_with_bands(self._core.with_pictures(pictures), pictures, names, composite), self._files)

    def __repr__(self):
        return f"<gpvc.Scene: {len(self.views)} views, {self.format}>"


class Mesh(NamedTuple):
    """A triangle mesh."""

    vertices: np.ndarray  #: (V, 3) float64
    faces: np.ndarray  #: (F, 3) uint32
    source_faces: np.ndarray  #: (F,) the polygon of the file that a face was cut from; empty where all are triangles


class Coverage(NamedTuple):
    """How photos together see each face: those that see at least half of it. Infinite where none does."""

    photos: np.ndarray  #: (F,) uint32, how many; the views of a panorama are one
    gsd: np.ndarray  #: (F,) float32, the smallest ground sampling distance: units of the mesh a pixel, on the face
    angle: np.ndarray  #: (F,) float32, the smallest angle between a photo's ray to the face and its normal, in degrees


class Result:
    """A textured mesh.

    uv: (F, 3, 2) float32, of each corner of each face on its page: (0, 0) is the page's upper left corner, (1, 1) the lower right
        one (glTF's convention, and that of Open3D's triangle_uvs and textures; OBJ and trimesh have v upwards: 1 - v).
    page: (F,) int32, index into `pages`; -1 for a face without texture.
    pages: list of (H, W, 3) uint8, read-only.
    page_names: what follows the model's name in the names of their files: "_0", or, with uv=, "_NAME", ".1001" and the like.
    samples: list of (H, W, bands) of the photos' own type, read-only, of the same texels as `pages`; 0 beside the charts. Empty where
        photos have no bands.
    bands: their names.
    labels: (F,) int32, the view that the face shows; -1: none.
    tags: (F,) uint8: 0 seen whole, 1 seen in parts, 2 filled from around it, 3 most photos show background in its place.
    report: dict of what the run says: "stages" with seconds and memory, "counts", "notes", "warnings", "device".
    """

    def __init__(self, core, bands):
        self._core = core
        self.samples, self.bands = core.samples(), list(bands)
        self.uv, self.page, self.pages = core.uv(), core.page(), core.pages()
        self.page_names = core.page_names()
        self.labels, self.tags = core.labels(), core.tags()
        self.report = json.loads(core.report)

    def save(self, path):
        """Writes the model, with the bytes that `gpvc texture` writes: NAME.glb; NAME.gltf with its parts; NAME.obj with NAME.mtl
        and its pages, with a .tif of all bands beside each where there are any; or, of a path without such an ending, a new folder with all of it and a preview. Files appear when all are
        complete."""
        path = _path(path, "path")
        ending = os.path.splitext(path)[1]
        if ending not in ("", ".glb", ".gltf", ".obj"):
            raise ValueError(f"path: {path!r} ends in {ending}, expected .glb, .gltf, .obj or a folder without an ending")
        _warn(self._core.save(path))

    def __repr__(self):
        return f"<gpvc.Result: {len(self.page)} faces, {len(self.pages)} pages>"


def _path(value, name):
    if not _pictures.is_path(value):
        raise TypeError(f"{name}: expected a path, got {type(value).__name__}")
    return os.fsdecode(value)


def _file(value, name):
    """A path as the bytes that the file system knows it by: not all names are UTF-8."""
    return os.fsencode(_path(value, name))


def _warn(sentences):
    for sentence in sentences:
        _warnings.warn(sentence, GpvcWarning, stacklevel=3)


def _mesh(vertices, faces):
    positions = _cameras.numbers(vertices, "vertices", {"(V, 3)": (None, 3)})
    if np.abs(positions).max(initial=0) > 1e18:
        raise ValueError("vertices: expected coordinates up to 1e18")
    triangles = np.asarray(faces)
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError(f"faces has shape {triangles.shape}, expected (F, 3)")
    if triangles.dtype.kind not in "iu":
        raise ValueError(f"faces has elements of {triangles.dtype}, expected whole numbers")
    if len(triangles) == 0:
        raise ValueError("faces has no faces")
    wrong = (triangles < 0) | (triangles >= len(positions))
    if wrong.any():
        row, corner = (int(i) for i in np.argwhere(wrong)[0])
        raise ValueError(f"faces[{row}, {corner}] is {triangles[row, corner]}, expected 0 to {len(positions) - 1}, an index of vertices")
    return np.ascontiguousarray(positions), np.ascontiguousarray(triangles, dtype=np.uint32)


def _sequence(values, name, count):
    if callable(values):
        return values
    if isinstance(values, np.ndarray) and values.ndim < 3 and values.dtype != object:
        raise ValueError(f"{name} has shape {values.shape}, expected a list of arrays and paths, or (N, H, W, C)")
    try:
        listed = list(values)
    except TypeError:
        raise TypeError(f"{name}: expected a list of arrays and paths, or a function, got {type(values).__name__}") from None
    if count is not None and len(listed) != count:
        raise ValueError(f"{name} has {len(listed)} entries, expected {count}, one for each pose of camera_from_world")
    return listed


def _band_names(bands, composite):
    for name, value in (("bands", bands), ("composite", composite)):
        if isinstance(value, str) or (value is not None and not all(isinstance(band, str) for band in value)):
            raise TypeError(f"{name}: expected a list of names")
    names = list(bands or ())
    if bands is not None and not 1 <= len(names) <= 32:
        raise ValueError(f"bands has {len(names)} names, expected 1 to 32")
    if len(set(names)) < len(names):
        raise ValueError("bands: expected names that differ")
    if composite is not None and bands is None:
        raise ValueError("composite: expected bands, too")
    return names


def _with_bands(core, pictures, names, composite):
    if not names:
        return core
    kind, some = pictures.type_and_some()
    return core.with_bands(names, kind, list(composite or ()), some)


def _pictures_for(images, masks, sizes, bands=0):
    images = _sequence(images, "images", len(sizes))
    masks = None if masks is None else _sequence(masks, "masks", len(sizes))
    for i, (width, height) in enumerate(sizes if not callable(images) else ()):
        size = _pictures.size_of(images[i], f"images[{i}]", bands)
        if size != (width, height):
            raise ValueError(f"images[{i}] is {size[0]} x {size[1]} pixels, expected {width} x {height}, the size of its camera")
    return _pictures.Pictures(images, masks, [tuple(size) for size in sizes], bands)


def _names(images, count):
    """Of views: paths where there are some, else numbers."""
    digits = len(str(max(count - 1, 0)))
    names = []
    for i in range(count):
        path = None if images is None or callable(images) else images[i]
        name = _path(path, "images").replace(os.sep, "/") if _pictures.is_path(path) else f"image_{i:0{digits}d}"
        names.append(name)
    seen = set()
    for i, name in enumerate(names):
        names[i] = name if name not in seen else f"{name} ({i})"
        seen.add(names[i])
    return names


def _sizes(images, image_size, count, bands):
    if image_size is not None:
        sizes = np.asarray(image_size)
        if sizes.dtype.kind not in "iu" or sizes.shape not in ((2,), (count, 2)) or (sizes < 1).any():
            raise ValueError(f"image_size: expected (width, height) or ({count}, 2), whole numbers above 0")
        return [(int(w), int(h)) for w, h in np.broadcast_to(sizes, (count, 2))]
    if images is None:
        raise ValueError("image_size: expected (width, height), as there are no images")
    if not callable(images):
        return [_pictures.size_of(image, f"images[{i}]", bands) for i, image in enumerate(images)]
    return None


class _First:
    """A function of images whose first image tells the size of all."""

    def __init__(self, images):
        self.images = images
        self.first = images(0)

    def __call__(self, i):
        if i == 0 and self.first is not None:
            first, self.first = self.first, None
            return first
        return self.images(i)


def _scene(images, K, camera_from_world, distortion, masks, image_size=None, bands=None, composite=None):
    """The Scene of the arguments that all functions share."""
    names = _band_names(bands, composite)
    if isinstance(images, Scene) or _pictures.is_path(images) or _cameras.is_reconstruction(images):
        if bands is not None:
            raise ValueError("bands: a scene has its own; read_scene(bands=...) or Scene.with_images() take others")
        given = {"K": K, "camera_from_world": camera_from_world, "distortion": distortion, "image_size": image_size}
        for name, value in given.items():
            if value is not None:
                raise ValueError(f"{name}: the scene that images names has its own; expected None")
        if masks is not None:
            raise ValueError("masks: a scene has its own; read_scene(masks=...) or Scene.with_images() take others")
        return images if isinstance(images, Scene) else read_scene(images)
    for name, value in {"K": K, "camera_from_world": camera_from_world}.items():
        if value is None:
            raise ValueError(f"{name}: expected an array, as images is no scene")
    rotations, translations = _cameras.poses(camera_from_world)
    count = len(rotations)
    if images is not None:
        images = _sequence(images, "images", count)
    intrinsics = _cameras.intrinsics(K, count)
    lenses = _cameras.lenses(distortion, count)
    masks = None if masks is None else _sequence(masks, "masks", count)
    sizes = _sizes(images, image_size, count, len(names))
    if sizes is None:
        images = _First(images)
        sizes = [_pictures.size_of(images.first, "images(0)", len(names))] * count
    in_files = images is not None and not callable(images) and all(_pictures.is_path(image) for image in images)
    masks_in_files = masks is None or (not callable(masks) and all(m is None or _pictures.is_path(m) for m in masks))
    if in_files and masks_in_files and not names:
        paths, mask_paths, pictures = images, masks or [None] * count, None
    else:
        paths, mask_paths = [None] * count, [None] * count
        pictures = _pictures.Pictures(images, masks, sizes, len(names))
        if images is not None and not callable(images):
            pictures = _pictures_for(images, masks, sizes, len(names))
    texts = [["" if p is None else _path(p, name) for p in given] for name, given in (("images", paths), ("masks", mask_paths))]
    core = _gpvc.Scene.of_cameras(
        _names(images, count), texts[0], texts[1], np.array(sizes, dtype=np.int32), intrinsics, lenses, rotations, translations,
        pictures,
    )
    return Scene(_with_bands(core, pictures, names, composite))


def _chosen(views, scene):
    """Ascending indices."""
    if views is None:
        return list(range(len(scene.views)))
    names = {view.name: i for i, view in enumerate(scene.views)}
    chosen = set()
    for view in views:
        if isinstance(view, str):
            if view not in names:
                raise ValueError(f"views: there is no view {view!r}")
            chosen.add(names[view])
        else:
            index = int(view)
            if index != view or not 0 <= index < len(scene.views):
                raise ValueError(f"views: {view!r} is no index of the {len(scene.views)} views")
            chosen.add(index)
    if not chosen:
        raise ValueError("views: expected at least one")
    return sorted(chosen)


def _rules(pairs, name, faces, scene):
    """(faces, views) as the module takes them."""
    rules = []
    for i, pair in enumerate(pairs or ()):
        try:
            which, views = pair
        except (TypeError, ValueError):
            raise ValueError(f"{name}[{i}]: expected a pair, (faces, views)") from None
        which = np.asarray(which)
        if which.dtype == bool:
            if which.shape != (faces,):
                raise ValueError(f"{name}[{i}]: its faces have shape {which.shape}, expected ({faces},) or numbers of faces")
            which = np.flatnonzero(which)
        if which.ndim != 1 or which.dtype.kind not in "iu" or len(which) == 0:
            raise ValueError(f"{name}[{i}]: expected (F,) bool or numbers of faces, at least one")
        if which.min() < 0 or which.max() >= faces:
            wrong = which.min() if which.min() < 0 else which.max()
            raise ValueError(f"{name}[{i}]: there is no face {wrong}, expected 0 to {faces - 1}")
        try:
            chosen = _chosen(views, scene) if len(views) or name == "forbid" else []
        except ValueError as error:
            raise ValueError(f"{name}[{i}]: {error}") from None
        rules.append((np.unique(which).tolist(), chosen, name == "allow", f"{name}[{i}]"))
    return rules


def _count(value, name, least):
    if isinstance(value, bool) or int(value) != value or value < least:
        raise ValueError(f"{name}={value!r}: expected a whole number from {least} on")
    return int(value)


def read_scene(source, images=None, masks=None, use_masks=True, downscale=1, skip_bad_photos=False, bands=None, composite=None):
    """Reads cameras and photos from a file or folder of any format that `gpvc` reads (COLMAP, OpenSfM, Metashape, nerfstudio and
    others), or from an object with pycolmap's attributes: `cameras` (model, width, height, params) and `images` (name, camera_id,
    cam_from_world with rotation and translation, each an attribute or a function).

    images: folder of the photos, at any depth, where the scene does not say where they are.
    masks: folder of masks, black where pixels must not be used. use_masks=False ignores masks and alpha channels.
    downscale: photos are reduced by this factor, 1 to 64.
    bands: a dict of folders that hold one band each, by its name; False: each photo's file holds all of its bands. Else files of
        bands are found by their cameras' names.
    composite: names or numbers (from 1 on) of the bands that are looked at as red, green and blue, or of a grey one.
    skip_bad_photos: leave out photos that are missing, damaged or of another shape; decodes all beforehand.
    """
    if not 1 <= _count(downscale, "downscale", 1) <= 64:
        raise ValueError(f"downscale={downscale}: expected 1 to 64")
    options = {
        "images": None if images is None else _file(images, "images"),
        "masks": None if masks is None else _file(masks, "masks"),
        "use_masks": bool(use_masks), "downscale": int(downscale), "skip_bad_photos": bool(skip_bad_photos),
        "allow_missing_photos": False, "bands_by_name": bands is not False,
        "bands": [(str(name), _file(folder, f"bands[{name!r}]")) for name, folder in dict(bands or {}).items()],
        "composite": [str(band) for band in composite or ()],
    }
    folder = None
    if _cameras.is_reconstruction(source):
        folder = _cameras.Folder()
        _cameras.write_colmap(source, folder.name)
    core = _gpvc.Scene.read(folder.name if folder else _file(source, "source"), options)
    _warn(core.warnings)
    return Scene(core, folder)


def read_mesh(path):
    """Reads a mesh: PLY, OBJ, STL, OFF, GLB or glTF. Polygons are cut into triangles."""
    vertices, faces, source_faces, sentences = _gpvc.read_mesh(_file(path, "path"))
    _warn(sentences)
    return Mesh(vertices, faces, source_faces)


def texture(vertices, faces, images, K=None, camera_from_world=None, distortion=None, masks=None, *, image_size=None, views=None,
            bands=None, composite=None, uv=None, allow=None, forbid=None, mesh_crs=None, progress=None, threads=0, device=None, **options):
    """Textures a mesh from calibrated photos. Returns a Result, whose save() writes GLB or OBJ.

    vertices, faces, images, K, camera_from_world, distortion, masks: see the module. Without K and camera_from_world, `images` is a
        Scene, its path, or an object with pycolmap's attributes.
    image_size: (width, height) or (N, 2), pixels, where `images` is a function; without it, all are as large as the first.
    views: indices or names of the views to texture from; the others are left out.
    bands, composite: names of the bands of arrays, see the module. Photos in files say what they hold.
    uv: texture coordinates that the mesh has, to be kept: (F, 3, 2), (V, 2), a Uv, or read_uv(model). Pages are then as large as a Uv
        says, or, where page_size is given, as that. Without, charts and pages are made.
    allow, forbid: lists of pairs (faces, views): these faces, numbers or (F,) bool, take texture from these views, indices or names,
        alone, or from all but these.
    mesh_crs: reference system of the vertices ("EPSG:25832") if it is not the cameras'.
    threads: processors to use at most; 0: all. Results do not depend on it.
    device: number of the OpenGL device to draw on; None: graphics hardware where there is some, else the processor.

    Raises ValueError (InputError) for arguments and files that cannot be used, OSError (OutputError) where no memory for pages can
    be had on disk, Error for a run that fails.

    Options, as of `gpvc texture`:

{options}
    """
    table = _gpvc.texture_options()
    options = _options.checked("texture", options, table)
    positions, triangles = _mesh(vertices, faces)
    scene = _scene(images, K, camera_from_world, distortion, masks, image_size, bands, composite)
    rules = [rule for name, pairs in (("allow", allow), ("forbid", forbid)) for rule in _rules(pairs, name, len(triangles), scene)]
    with _Progress(progress) as call:
        result = Result(_gpvc.texture(
            scene._core, positions, triangles, _chosen(views, scene), options, mesh_crs or "", _count(threads, "threads", 0),
            -1 if device is None else _count(device, "device", 0),
            _uv.core_of(uv, triangles, len(positions)), rules, call), scene.bands)
    _warn(result.report["warnings"])
    return result


def _classes(vertices, faces, images, K, camera_from_world, distortion, masks, image_size, mesh_crs, device, options, function):
    options = _options.checked(function, options, _gpvc.visibility_options())
    positions, triangles = _mesh(vertices, faces)
    scene = _scene(images, K, camera_from_world, distortion, masks, image_size)
    seen = _gpvc.ViewClasses(scene._core, positions, triangles, options, mesh_crs or "",
                             -1 if device is None else _count(device, "device", 0))
    _warn(seen.warnings)
    return seen


def visibility(vertices, faces, images, K=None, camera_from_world=None, distortion=None, masks=None, *, image_size=None,
               mesh_crs=None, device=None, **options):
    """Yields, for each view, the class of each face: (F,) uint8, 0 hidden, 1 seen in part, 2 seen whole. Exact: without a
    tolerance.

    Photos are not decoded; `images` may be None where image_size states their size. Where there are masks or alphas, what they
    exclude counts as outside the photo.

    Options, as of `gpvc visibility`:

{visibility_options}
    """
    seen = _classes(vertices, faces, images, K, camera_from_world, distortion, masks, image_size, mesh_crs, device, options,
                    "visibility")
    return (seen.classes(i) for i in range(len(seen)))


def face_ids(vertices, faces, images, K=None, camera_from_world=None, distortion=None, masks=None, *, image_size=None,
             mesh_crs=None, of_photo=False, device=None, **options):
    """Yields, for each view, the face that each pixel's centre sees: (H, W) int32, -1 where there is none, or no photo.

    of_photo: False: pixels are those of the frame, the photo without its distortion. True: those of the photo as it is; each has the
        face of the frame's pixel that it lies in.

    Other arguments, and options, as of visibility().
    """
    seen = _classes(vertices, faces, images, K, camera_from_world, distortion, masks, image_size, mesh_crs, device, options,
                    "face_ids")
    return (seen.face_ids(i, bool(of_photo)) for i in range(len(seen)))


def coverage(vertices, faces, images, K=None, camera_from_world=None, distortion=None, masks=None, *, image_size=None,
             mesh_crs=None, progress=None, device=None, **options):
    """How well the photos together see each face: a Coverage of the number of photos, the best ground sampling distance and the
    best angle, the numbers of `gpvc coverage`. Arguments and options as of visibility()."""
    options = _options.checked("coverage", options, _gpvc.visibility_options())
    positions, triangles = _mesh(vertices, faces)
    scene = _scene(images, K, camera_from_world, distortion, masks, image_size)
    with _Progress(progress) as call:
        *arrays, sentences = _gpvc.coverage(scene._core, positions, triangles, options, mesh_crs or "",
                                            -1 if device is None else _count(device, "device", 0), call)
    _warn(sentences)
    return Coverage(*arrays)


def evaluate(model, images, K=None, camera_from_world=None, distortion=None, masks=None, *, image_size=None, views=None,
             reduction=4, output=None, progress=None):
    """Renders a textured model from every view and compares it with the photos. Returns a dict: "mean" and, by name, "views", each
    with psnr (dB), ssim, ncc_error, completeness and others; None where one means nothing.

    model: path of an OBJ, PLY, GLB or glTF, or a Result.
    views: indices or names of the views to compare with; photos that the model was not textured from judge it best.
    reduction: photos and renders are compared at 1/reduction of their size.
    output: folder for pictures of photo, render and error; None: none.
    """
    scene = _scene(images, K, camera_from_world, distortion, masks, image_size)
    is_result = isinstance(model, Result)
    if is_result and model._core.views != len(scene.views):
        raise ValueError(f"images: the result was textured from a scene of {model._core.views} views, and this one has {len(scene.views)}")
    with _Progress(progress) as call:
        report = json.loads(_gpvc.evaluate(
            scene._core, _chosen(views, scene), model._core if is_result else None, "" if is_result else _path(model, "model"),
            "" if output is None else _path(output, "output"), _count(reduction, "reduction", 1), call))
    _warn(report["warnings"])
    return report


texture.__doc__ = texture.__doc__.replace("{options}", _options.documented(_gpvc.texture_options()))
visibility.__doc__ = visibility.__doc__.replace("{visibility_options}", _options.documented(_gpvc.visibility_options()))
