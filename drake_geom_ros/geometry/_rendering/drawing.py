"""Rendering of the requested images from posed bodies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._rendering.kernels.bands import draw_bands, pose_meshes
from drake_geom_ros.geometry._rendering.kernels.primitives import find_windows
from drake_geom_ros.geometry._rendering.kernels.records import (
    Band,
    Bodies,
    Floats,
    Outputs,
    Paint,
    Seen,
    Windows,
)

# Pixels of a band: half a megabyte of buffers, which stays in a core's cache. Each band passes all
# triangles, each at the cost of PIXELS_OF_TRIANGLE: with many triangles a band is larger, up to
# 8 MB.
BAND_PIXELS, PIXELS_OF_TRIANGLE, MOST_PIXELS = 2**15, 16, 2**19


class Lens(NamedTuple):
    """Intrinsics of a camera, its range of depths, and the world's up direction in its frame."""

    width: int
    height: int
    focal: tuple[float, float]
    centre: tuple[float, float]
    clipping: tuple[float, float]
    depth_range: tuple[float, float]
    up_C: Floats


class Shading(NamedTuple):
    """Options of the colours of an image."""

    background: Floats  # (3,) from 0 to 1
    edges: bool
    samples: int  # per pixel and axis


class Wanted(NamedTuple):
    """The images to render."""

    color: bool = False
    depth: bool = False
    label: bool = False


_NOTHING = Outputs(
    np.empty((0, 0), np.uint32), np.empty((0, 0, 1), np.float32), np.empty((0, 0, 1), np.int16)
)


def render(
    bodies: Bodies,
    placed: NDArray[np.bool_],
    R_CGs: Floats,
    p_CGs: Floats,
    lens: Lens,
    look: Shading,
    wanted: Wanted,
    empty: int,
) -> Outputs:
    """Return images of the bodies that are ``placed`` (n,), posed in the camera's frame.

    ``empty`` is the label of pixels that show no body.
    """
    shape = lens.height, lens.width
    outputs = Outputs(
        np.empty(shape, np.uint32) if wanted.color else _NOTHING.color,
        np.empty((*shape, 1), np.float32) if wanted.depth else _NOTHING.depth,
        np.empty((*shape, 1), np.int16) if wanted.label else _NOTHING.label,
    )
    everybody, coarse = bool(bodies.is_labelled.all()), look.samples == 1
    first = outputs
    # Labels of only some bodies, and finer colours, need separate passes.
    if not everybody:
        first = first._replace(label=_NOTHING.label)
        fewer = _Pass(bodies, placed & bodies.is_labelled, R_CGs, p_CGs, lens)
        fewer.draw(_NOTHING._replace(label=outputs.label), look, empty)
    if not coarse:
        first = first._replace(color=_NOTHING.color)
        fine = _Pass(bodies, placed, R_CGs, p_CGs, lens, look.samples)
        fine.draw_fine(outputs.color, look)
    _Pass(bodies, placed, R_CGs, p_CGs, lens).draw(first, look, empty)
    return outputs


def bytes_of(colours: NDArray[np.uint32]) -> NDArray[np.uint8]:
    """Return pixels (height, width) as bytes red, green, blue and alpha (height, width, 4)."""
    return colours.view(np.uint8).reshape(*colours.shape, 4)


class _Pass:
    """Bodies seen by a camera: posed, with windows that bound their pixels."""

    def __init__(
        self,
        bodies: Bodies,
        shown: NDArray[np.bool_],
        R_CGs: Floats,
        p_CGs: Floats,
        lens: Lens,
        samples: int = 1,
    ) -> None:
        self._bodies = bodies
        self._samples = samples
        self._size = lens.width * samples, lens.height * samples
        intrinsics = np.array([*lens.focal, *lens.centre]) * samples
        view = np.array([*intrinsics, *lens.clipping, *lens.up_C, 0.0])
        poses = np.ascontiguousarray(R_CGs), np.ascontiguousarray(p_CGs)
        windows, nearest = np.zeros((len(bodies.kinds), 4), np.int64), np.zeros(len(bodies.kinds))
        p_CVs = np.empty_like(bodies.p_GVs)
        body_windows = Windows(windows, nearest)
        find_windows(bodies, *poses, view, self._size, body_windows)
        if len(bodies.p_GVs):
            scratch = np.eye(3), np.zeros(3)
            pose_meshes(bodies, *poses, p_CVs, view, self._size, scratch, body_windows)
        # From front to back, because hidden pixels cost least.
        order = np.argsort(nearest, kind='stable')
        slopes = (np.arange(self._size[0]) + 0.5 - intrinsics[2]) / intrinsics[0]
        self._seen = Seen(order[shown[order]], *poses, p_CVs, windows, nearest, view, slopes)
        self._depth_range = lens.depth_range

    def draw(self, outputs: Outputs, look: Shading, empty: int) -> None:
        """Fill the requested images."""
        if not any(image.size for image in outputs):
            return
        self._draw(outputs, self._buffers(1), self._paint(look), empty)

    def draw_fine(self, colour: NDArray[np.uint32], look: Shading) -> None:
        """Fill a colour image, if requested, with pixels that are means of samples."""
        if not colour.size:
            return
        (width, height), n = self._size, self._samples
        paint, buffers = self._paint(look), self._buffers(n)
        rows = len(buffers.depths)
        for first in range(0, height, rows):
            count = min(rows, height - first)
            fine = np.empty((count, width), np.uint32)
            # One compiled entry for both kinds of images: a second one takes 13 s.
            self._draw(_NOTHING._replace(color=fine), buffers, paint, 0, first)
            parts = bytes_of(fine).reshape(count // n, n, width // n, n, 4)
            # Whole numbers, rounded half up: the same on every machine.
            sums = parts.sum(axis=(1, 3), dtype=np.uint32)
            bytes_of(colour)[first // n : (first + count) // n] = (2 * sums + n * n) // (2 * n * n)

    def _draw(
        self, outputs: Outputs, buffers: Band, paint: Paint, empty: int, top: int = 0
    ) -> None:
        """Fill the requested images, which begin in the row ``top`` of the pass."""
        bodies, seen, depths = self._bodies, self._seen, self._depth_range
        draw_bands(bodies, seen, buffers, paint, depths, empty, top, outputs)

    def _buffers(self, step: int) -> Band:
        """Return buffers for the largest band, a multiple of ``step`` rows."""
        width, height = self._size
        triangles = len(self._bodies.triangles)
        pixels = max(BAND_PIXELS, min(PIXELS_OF_TRIANGLE * triangles, MOST_PIXELS))
        shape = min(max(pixels // width // step, 1) * step, height), width
        return Band(0, np.empty(shape), np.empty(shape, np.int32), np.empty(shape, np.int32))

    def _paint(self, look: Shading) -> Paint:
        """Return the options and scratch arrays of colours."""
        width = self._size[0]
        above, normals = np.full(width, -1, np.int32), np.zeros((2, 3, width))
        light = np.empty(width, np.float32)
        return Paint(look.background, look.edges, above, normals, light)
