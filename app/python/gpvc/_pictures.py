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


def _picture_array(value, name):
    array = np.asarray(value)
    if array.ndim == 2:
        array = array[:, :, np.newaxis]
    if array.ndim != 3 or array.shape[2] not in (1, 2, 3, 4) or 0 in array.shape:
        raise ValueError(f"{name} has shape {np.shape(value)}, expected (H, W) or (H, W, C) with 1 to 4 channels")
    return array


def size_of(value, name):
    """(width, height) of a path or an array."""
    if is_path(value):
        return _gpvc.image_size(os.fspath(value))
    height, width = _picture_array(value, name).shape[:2]
    return width, height


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

    def __init__(self, images, masks, sizes):
        self.images, self.masks, self.sizes = images, masks, sizes

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

    def picture(self, i):
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
        if self.images is not None:
            value, name = self._given(self.images, "images", i)
            if is_path(value):
                transparent = _gpvc.read_photo(os.fspath(value), "")[1] if _gpvc.has_alpha(os.fspath(value)) else None
            else:
                array = _picture_array(value, name)
                self._check(array.shape, name, i)
                transparent = array[:, :, -1] == 0 if array.shape[2] in (2, 4) else None
        return _either(transparent, self._mask(i))


def _either(a, b):
    return b if a is None else a if b is None else a | b
