"""Height maps of SDFormat: grey images as height fields, scaled and turned as Gazebo does it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.geometry import HeightField
from drake_geom_ros.geometry.shapes.height_field import MOST_HEIGHTS
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.sdf_elements import SdfFile, numbers_in, text_of

_MISSING = (
    'Pillow is not installed, and images of height maps take it: pip install pillow, or this '
    "package with its extra 'models'"
)
# Modes of Pillow whose first channel is a height: grey of 1, 8, 16 and 32 bits, and colours.
_GREY = ('1', 'L', 'I;16', 'I;16B', 'I')
_COLOURS = ('LA', 'P', 'RGB', 'RGBA')


def height_field_of(heightmap: Any, file: SdfFile, resolver: ResourceResolver) -> HeightField:
    """Return the terrain of a ``<heightmap>``, about the middle of its grid.

    A pixel is a height. Columns run along x, and rows along -y, so that the first row is at the
    largest y. Black is at height 0, and the brightest pixel of the image at ``<size>``'s z. The
    solid below the terrain is as deep as the largest of the sizes. Raises ValueError or
    RuntimeError, which name no line, for a size that is not positive and for an image that is
    missing, not grey, or too large.
    """
    uri = text_of(heightmap, 'uri')
    if not uri:
        raise ValueError('<heightmap> has no <uri>')
    size = numbers_in(heightmap, 'size', 3, '1 1 1')
    if min(size) <= 0.0:
        raise ValueError(f'<size> of a <heightmap> is {size}; its three numbers must be > 0 [m]')
    shades = _shades(resolver.resolve(uri, file.folder))
    rows, columns = shades.shape
    heights = shades * (size[2] / (shades.max() or 1.0))
    xs = np.linspace(-0.5 * size[0], 0.5 * size[0], columns)
    ys = np.linspace(-0.5 * size[1], 0.5 * size[1], rows)
    return HeightField(xs, ys, heights[::-1].T, heights.min() - max(size))


def _shades(path: Path) -> Floats:
    """Return the grey values (rows, columns) of an image, the first row on top."""
    try:
        from PIL import Image
    except ImportError:
        raise ValueError(_MISSING) from None
    try:
        with Image.open(path) as image:
            columns, rows = image.size
            if columns * rows > MOST_HEIGHTS or min(image.size) < 2:
                raise ValueError(
                    f'it has {columns} x {rows} pixels; read are 2 x 2 and more, up to '
                    f'{MOST_HEIGHTS} in all'
                )
            if image.mode not in (*_GREY, *_COLOURS):
                raise ValueError(f'its mode is {image.mode}; read are grey images')
            if image.mode in _COLOURS:
                red, green, blue = (np.asarray(each) for each in image.convert('RGB').split())
                if not (np.array_equal(red, green) and np.array_equal(red, blue)):
                    raise ValueError('it has colours; read are grey images')
                return red.astype(np.float64)
            shades = np.asarray(image).astype(np.float64)
    except (OSError, SyntaxError, ValueError) as error:
        raise ValueError(f'the image {path} of a <heightmap> cannot be read: {error}') from None
    if shades.min() < 0.0:
        raise ValueError(f'the image {path} of a <heightmap> has values below 0')
    return shades
