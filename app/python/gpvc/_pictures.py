"""Pictures and masks that the caller holds or makes, as the library takes them."""

import os

import numpy as np

from . import _gpvc


def is_path(value):
    return isinstance(value, (str, os.PathLike))


def _eight_bits(samples, name):
    """As the library decodes files: whole numbers of 16 bits are scaled, floats are 0 to 1, both rounded to nearest."""
    if samples.dtype == np.uint8:
        return samples
    if samples.dtype == np.uint16:
        return ((samples.astype(np.uint32) * 255 + 32767) // 65535).astype(np.uint8)
    if samples.dtype in (np.float32, np.float64):
        return (np.clip(np.nan_to_num(samples, nan=0.0), 0, 1) * 255 + 0.5).astype(np.uint8)
    raise ValueError(f"{name} has samples of {samples.dtype}, expected uint8, uint16, float32 or float64")


def _picture_array(value, name, bands=0):
    """(H, W, C); of pictures with bands, C is their number."""
    array = np.asarray(value)
    if array.ndim == 2:
        array = array[:, :, np.newaxis]
    if array.ndim != 3 or 0 in array.shape or array.shape[2] not in ([bands] if bands else (1, 2, 3, 4)):
        expected = f"(H, W, {bands}), as many as bands has names" if bands else "(H, W) or (H, W, C) with 1 to 4 channels"
        more = "; bands=[...] names more" if not bands and array.ndim == 3 and array.shape[2] > 4 else ""
        raise ValueError(f"{name} has shape {np.shape(value)}, expected {expected}{more}")
    return array


def size_of(value, name, bands=0):
    """(width, height) of a path or an array."""
    if is_path(value):
        if bands:
            raise ValueError(f"{name} is a path, {_NO_PATH}")
        return _gpvc.image_size(os.fspath(value))
    height, width = _picture_array(value, name, bands).shape[:2]
    return width, height


_NO_PATH = "expected an array of bands; read_scene() reads bands from files"
_SAMPLE_TYPES = {np.dtype(np.uint8): "u8", np.dtype(np.uint16): "u16", np.dtype(np.float32): "f32"}


def _rgb(array, name):
    """(H, W, 3) uint8, C-contiguous: the array itself where it is that."""
    channels = array.shape[2]
    colours = array if channels == 3 else array[:, :, :3] if channels == 4 else np.repeat(array[:, :, :1], 3, axis=2)
    return np.ascontiguousarray(_eight_bits(colours, name))


def _masked(value, name):
    """True where a mask excludes, by the rule of mask files: what is darker than half of white, or, where nothing is as bright
    (labels 0 and 1), 0 alone."""
    array = np.asarray(value)
    if array.ndim == 3:
        array = array.max(axis=2)
    if array.ndim != 2:
        raise ValueError(f"{name} has shape {np.shape(value)}, expected (H, W)")
    if array.dtype == bool:
        return ~array
    if array.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        raise ValueError(f"{name} has samples of {array.dtype}, expected bool, uint8, uint16, float32 or float64")
    white = {np.dtype(np.uint8): 255, np.dtype(np.uint16): 65535}.get(array.dtype, 1)
    bright = array > (white // 2 if white > 1 else 0.5)
    return ~bright if bright.any() else array == 0


class Pictures:
    """`images`: a sequence of paths and arrays, or a function of an index; `masks` likewise, or None. Of the sizes of the cameras."""

    def __init__(self, images, masks, sizes, bands=0):
        self.images, self.masks, self.sizes, self.bands = images, masks, sizes, bands
        self.type = None  # of the samples of bands

    def _given(self, values, what, i):
        if not callable(values):
            return values[i], f"{what}[{i}]"
        name = f"{what}({i})"
        try:
            return values(i), name
        except Exception as error:
            error.add_note(f"raised by {name}, which gpvc called")
            raise

    def _check(self, shape, name, i):
        width, height = self.sizes[i]
        if tuple(shape[:2]) != (height, width):
            raise ValueError(f"{name} is {shape[1]} x {shape[0]} pixels, expected {width} x {height}, the size of its camera")

    def _mask(self, i):
        if self.masks is None:
            return None
        value, name = self._given(self.masks, "masks", i)
        if value is None:
            return None
        excluded = _gpvc.read_photo("", os.fspath(value))[1] if is_path(value) else _masked(value, name)
        if excluded is not None:
            self._check(excluded.shape, name, i)
        return excluded

    def _samples(self, i):
        """(H, W, bands), C-contiguous, and (H, W), true where a band has no number, or None."""
        value, name = self._given(self.images, "images", i)
        if is_path(value):
            raise ValueError(f"{name} is a path, {_NO_PATH}")
        array = _picture_array(value, name, self.bands)
        self._check(array.shape, name, i)
        if array.dtype not in _SAMPLE_TYPES:
            raise ValueError(f"{name} has samples of {array.dtype}, expected uint8, uint16 or float32, as bands are kept")
        if self.type is None:
            self.type = array.dtype
        if array.dtype != self.type:
            raise ValueError(f"{name} has samples of {array.dtype}, others of {self.type}: expected one type for all images")
        missing = None
        if array.dtype == np.float32 and not np.isfinite(array).all():
            missing = ~np.isfinite(array).all(axis=2)
            array = np.where(np.isfinite(array), array, np.float32(0))
        return np.ascontiguousarray(array), missing

    def type_and_some(self):
        """The type of the samples, and some of up to eight pictures: those that the library would look at in files."""
        some, count = [], min(8, len(self.sizes))
        for n in range(count):
            i = n * len(self.sizes) // count
            array, missing = self._samples(i)
            excluded = _either(missing, self._mask(i))
            pixels = array.reshape(-1, self.bands)
            step = len(pixels) // 40000 // 2 * 2 + 1
            used = slice(None) if excluded is None else ~excluded.ravel()[::step]
            some.append(pixels[::step][used].astype(np.float32).ravel())
        return _SAMPLE_TYPES[self.type], np.concatenate(some)

    def picture(self, i):
        if self.bands:
            samples, missing = self._samples(i)
            return samples, _either(missing, self._mask(i))
        value, name = self._given(self.images, "images", i)
        if is_path(value):
            rgb, transparent = _gpvc.read_photo(os.fspath(value), "")
        else:
            array = _picture_array(value, name)
            rgb = _rgb(array, name)
            transparent = array[:, :, -1] == 0 if array.shape[2] in (2, 4) else None
        self._check(rgb.shape, name, i)
        return rgb, _either(transparent, self._mask(i))

    def excluded(self, i):
        """What picture(i) excludes, without making the picture where it tells nothing."""
        transparent = None
        if self.bands:
            transparent = self._samples(i)[1]
        elif self.images is not None:
            value, name = self._given(self.images, "images", i)
            if is_path(value):
                transparent = _gpvc.read_photo(os.fspath(value), "")[1] if _gpvc.hides_pixels(os.fspath(value)) else None
            else:
                array = _picture_array(value, name)
                self._check(array.shape, name, i)
                transparent = array[:, :, -1] == 0 if array.shape[2] in (2, 4) else None
        return _either(transparent, self._mask(i))


def _either(a, b):
    return b if a is None else a if b is None else a | b
