"""Overlays on pictures of scenes: pairs as lines, contact surfaces coloured by pressure."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.viewing.looks import PAIR_COLOURS
from drake_geom_ros.viewing.patches import Patches, colours_of, in_pascals
from drake_geom_ros.viewing.shown_pairs import ReportedPairs

Pixels = NDArray[np.uint8]

MOST_PAIRS = 200  # lines in a picture, of the nearest pairs
_MOST_TEXTS = 5  # distances written beside lines, of the nearest pairs with free space
_TEXT = (60, 14)  # [pixels] size of such a text in a small image
_LINES = 30  # texts that would fit above one another in a large image
_SAMPLES = 2  # of a patch along each side of a pixel
_SCALE = (120, 10, 8)  # [pixels] length, height, and distance to the lower left corner


def with_pairs(pixels: Pixels, ends: Floats, pairs: ReportedPairs) -> Pixels:
    """Return an image with lines between nearest points, and the distances of the nearest pairs.

    ``ends`` (k, 2, 2) [pixels] are the pairs' witness points in the image, NaN if behind the
    camera.
    """
    image, pen = _drawable(pixels)
    scale = _scale_of(pixels)
    order = np.argsort(-pairs.distance, kind='stable')[-MOST_PAIRS:]  # the nearest on top
    ends = ends[order]
    for row, line in zip(order.tolist(), ends, strict=True):
        if not np.isfinite(line).all():
            continue
        overlaps = pairs.distance[row] < 0.0
        colour = _bytes('contacts' if overlaps else 'distances')
        a, b = (tuple(end) for end in line.tolist())
        pen.line([a, b], fill=(0, 0, 0), width=round(3 * scale) + 2)
        pen.line([a, b], fill=colour, width=round(3 * scale))
        for x, y in (a, b):
            r = 3.0 * scale
            pen.ellipse((x - r, y - r, x + r, y + r), fill=colour, outline=(0, 0, 0))
    written: list[Floats] = []
    for row, line in zip(order[::-1].tolist(), ends[::-1], strict=True):
        place = line.mean(axis=0)
        near = any((np.abs(place - other) < scale * np.array(_TEXT)).all() for other in written)
        if len(written) < _MOST_TEXTS and not near and np.isfinite(place).all():
            written.append(place)
            x, y = place.tolist()
            text = f'{1e3 * pairs.distance[row]:.1f} mm'
            _write(pen, (x + 6 * scale, y - (_TEXT[1] + 2) * scale), text, scale)
    return np.asarray(image)


def with_patches(pixels: Pixels, at: Floats, z: Floats, patches: Patches) -> Pixels:
    """Return an image with contact surfaces coloured by pressure, and a scale.

    ``at`` (v, 2) [pixels] are their corners in the image, NaN if behind the camera, and ``z``
    (v,) [m] their depths.
    """
    height, width = pixels.shape[:2]
    size = _SAMPLES * height, _SAMPLES * width
    pressures = _seen(size, _SAMPLES * at, z, patches)
    is_hit = np.isfinite(pressures)
    colours = 255.0 * colours_of(np.where(is_hit, pressures, 0.0), patches.max_pressure)
    blocks = (height, _SAMPLES, width, _SAMPLES)
    share = is_hit.reshape(blocks).mean(axis=(1, 3))[..., None]
    painted = (colours * is_hit[..., None]).reshape(*blocks, 3).mean(axis=(1, 3))
    blended: Pixels = np.rint(painted + (1.0 - share) * pixels).astype(np.uint8)
    return _with_scale(blended, patches.max_pressure)


def _seen(size: tuple[int, int], at: Floats, z: Floats, patches: Patches) -> Floats:
    """Return the pressure (h, w) [Pa] of the nearest patch at each pixel; NaN: no patch."""
    pressures, nearest = np.full(size, np.nan), np.full(size, np.inf)
    limits = np.array([size[1], size[0]])
    # A quantity that is linear in space, divided by z, is linear in the image.
    z = np.where(z > 0.0, z, np.nan)
    values = np.column_stack((1.0 / z, patches.pressures / z))
    for triangle in patches.triangles:
        corners = at[triangle]
        if not np.isfinite(corners).all():
            continue
        low = np.maximum(np.floor(corners.min(axis=0)), 0).astype(int)
        high = np.minimum(np.ceil(corners.max(axis=0)), limits).astype(int)
        edges = corners[1:] - corners[0]
        twice = edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0]
        if (high <= low).any() or twice == 0.0:
            continue
        x = np.arange(low[0], high[0])[None, :] + 0.5 - corners[0, 0]
        y = np.arange(low[1], high[1])[:, None] + 0.5 - corners[0, 1]
        b = (x * edges[1, 1] - y * edges[1, 0]) / twice
        c = (y * edges[0, 0] - x * edges[0, 1]) / twice
        first, second, third = values[triangle]
        mixed = first + b[..., None] * (second - first) + c[..., None] * (third - first)
        inside = (b >= 0.0) & (c >= 0.0) & (b + c <= 1.0)
        place = slice(low[1], high[1]), slice(low[0], high[0])
        with np.errstate(divide='ignore', invalid='ignore'):
            distance, pressure = 1.0 / mixed[..., 0], mixed[..., 1] / mixed[..., 0]
        nearer = inside & (distance < nearest[place])
        nearest[place][nearer], pressures[place][nearer] = distance[nearer], pressure[nearer]
    return pressures


def _with_scale(pixels: Pixels, most: float) -> Pixels:
    """Return an image with a scale of colours, up to the greatest pressure, in its corner."""
    length, height, margin = _SCALE
    length = min(length, pixels.shape[1] - 2 * margin)
    top = pixels.shape[0] - margin - height
    if length <= 0 or top < _TEXT[1]:
        return pixels  # the image is too small
    scaled = pixels.copy()
    shades = 255.0 * colours_of(np.linspace(0.0, most, length), most)
    scaled[top : top + height, margin : margin + length] = np.rint(shades).astype(np.uint8)
    image, pen = _drawable(scaled)
    pen.rectangle((margin - 1, top - 1, margin + length, top + height), outline=(0, 0, 0))
    _write(pen, (margin, top - _TEXT[1]), f'0 to {in_pascals(most)}')
    return np.asarray(image)


def _drawable(pixels: Pixels) -> tuple[Any, Any]:
    """Return a Pillow image of pixels, and its ImageDraw."""
    try:
        from PIL import Image, ImageDraw
    except ImportError as error:
        raise GeometryError(f'pictures need pillow ({error}): pip install pillow') from None
    image = Image.fromarray(pixels)
    return image, ImageDraw.Draw(image)


def _scale_of(pixels: Pixels) -> float:
    """Return by how much lines and texts of an image are larger than those of a small one."""
    height: int = pixels.shape[0]
    return max(1.0, height / (_LINES * _TEXT[1]))


def _write(pen: Any, place: tuple[float, float], text: str, scale: float = 1.0) -> None:
    size = round(scale * (_TEXT[1] - 3))
    pen.text(place, text, fill=(0, 0, 0), stroke_width=2, stroke_fill='white', font_size=size)


def _bytes(name: str) -> tuple[int, int, int]:
    red, green, blue, _ = PAIR_COLOURS[name]
    return round(255 * red), round(255 * green), round(255 * blue)
