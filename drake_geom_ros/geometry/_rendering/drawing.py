"""One pass over all bodies, and the images that were asked for of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._rendering.kernels.bands import Band, draw_band, pose_meshes
from drake_geom_ros.geometry._rendering.kernels.primitives import find_windows
from drake_geom_ros.geometry._rendering.kernels.shading import (
    write_colours,
    write_depths,
    write_labels,
)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Pixels that are drawn at once: in half a megabyte, which stays in a core's cache. Each band
# passes all triangles, which costs as much as so many pixels each: where there are many of them
# it is larger, up to 8 MB.
BAND_PIXELS, PIXELS_OF_TRIANGLE, MOST_PIXELS = 2**15, 16, 2**19


class Bodies(NamedTuple):
    """What is shown, in ascending order of ids; a mesh has the kind CONVEX, and its triangles."""

    kinds: Indices  # (n,) shape type numbers
    shapes: Floats  # (n, 3), see ``kernels``
    colours: Floats  # (n, 3) from 0 to 1
    labels: NDArray[np.int16]  # (n,)
    is_labelled: NDArray[np.bool_]  # (n,) false: left out of label images
    vertex_starts: Indices  # (n + 1,)
    p_GVs: Floats  # (v, 3) [m]
    triangle_starts: Indices  # (n + 1,)
    triangles: NDArray[np.int32]  # (f, 3) rows of p_GVs
    facet_colours: NDArray[np.float32]  # (f, 3); below 0: that of the body


class Lens(NamedTuple):
    """A camera's intrinsics, the depths it tells, and the world's up in it."""

    width: int
    height: int
    focal: tuple[float, float]
    centre: tuple[float, float]
    clipping: tuple[float, float]
    depth_range: tuple[float, float]
    up_C: Floats


class Look(NamedTuple):
    """How colours are made."""

    background: Floats  # (3,) from 0 to 1
    edges: bool
    samples: int  # a pixel and axis


class Wanted(NamedTuple):
    """Which images are made."""

    color: bool = False
    depth: bool = False
    label: bool = False


class Images(NamedTuple):
    """What was made: arrays (height, width, channels), or None."""

    color: NDArray[np.uint8] | None
    depth: NDArray[np.float32] | None
    label: NDArray[np.int16] | None


def render(
    bodies: Bodies,
    placed: NDArray[np.bool_],
    R_CGs: Floats,
    p_CGs: Floats,
    lens: Lens,
    look: Look,
    wanted: Wanted,
    empty: int,
) -> Images:
    """Return images of the bodies that are ``placed`` (n,), posed in the camera.

    ``empty`` is the label of nothing.
    """
    shape = lens.height, lens.width
    images = Images(
        np.empty((*shape, 4), np.uint8) if wanted.color else None,
        np.empty((*shape, 1), np.float32) if wanted.depth else None,
        np.empty((*shape, 1), np.int16) if wanted.label else None,
    )
    everybody, coarse = bool(bodies.is_labelled.all()), look.samples == 1
    whole = _Pass(bodies, placed, R_CGs, p_CGs, lens)
    whole.draw(
        images._replace(
            color=images.color if coarse else None, label=images.label if everybody else None
        ),
        look,
        empty,
    )
    # Labels of fewer bodies, and finer colours, are passes of their own.
    if not everybody:
        fewer = _Pass(bodies, placed & bodies.is_labelled, R_CGs, p_CGs, lens)
        fewer.draw(Images(None, None, images.label), look, empty)
    if images.color is not None and not coarse:
        fine = _Pass(bodies, placed, R_CGs, p_CGs, lens, look.samples)
        fine.draw_fine(images.color, look)
    return images


class _Pass:
    """Bodies seen by a camera: posed, with the windows of pixels that they can be in."""

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
        self._poses = np.ascontiguousarray(R_CGs), np.ascontiguousarray(p_CGs)
        self._samples = samples
        self._size = lens.width * samples, lens.height * samples
        intrinsics = np.array([*lens.focal, *lens.centre]) * samples
        self._view = np.array([*intrinsics, *lens.clipping, *lens.up_C, 0.0])
        self._slopes = (np.arange(self._size[0]) + 0.5 - intrinsics[2]) / intrinsics[0]
        self._depth_range = lens.depth_range
        count = len(bodies.kinds)
        self._windows = np.zeros((count, 4), np.int64)
        self._nearest = np.zeros(count)
        self._p_CVs = np.empty_like(bodies.p_GVs)
        find_windows(
            *(bodies.kinds, bodies.shapes, *self._poses, self._view, *self._size),
            *(self._windows, self._nearest),
        )
        if len(bodies.p_GVs):
            pose_meshes(
                *(bodies.kinds, *self._poses, bodies.vertex_starts, bodies.p_GVs, self._p_CVs),
                *(self._view, self._size, np.eye(3), np.zeros(3), self._windows, self._nearest),
            )
        # From front to back, for what is hidden costs least.
        order = np.argsort(self._nearest, kind='stable')
        self._order = order[shown[order]]

    def draw(self, images: Images, look: Look, empty: int) -> None:
        """Fill the images that are there."""
        if all(image is None for image in images):
            return
        neighbours = self._neighbours()
        for band in self._bands(1):
            rows = slice(band.first_row, band.first_row + len(band.depths))
            if images.depth is not None:
                write_depths(band.depths, *self._depth_range, images.depth[rows])
            if images.label is not None:
                write_labels(band.owners, self._bodies.labels, empty, images.label[rows])
            if images.color is not None:
                self._write_colours(band, look, neighbours, images.color[rows])

    def draw_fine(self, colour: NDArray[np.uint8], look: Look) -> None:
        """Fill a colour image whose pixels are means of samples."""
        width, n = self._size[0], self._samples
        neighbours = self._neighbours()
        for band in self._bands(n):
            count = len(band.depths)
            fine = np.empty((count, width, 4), np.uint8)
            self._write_colours(band, look, neighbours, fine)
            parts = fine.reshape(count // n, n, width // n, n, 4)
            # Whole numbers, rounded half up: the same on every machine.
            sums = parts.sum(axis=(1, 3), dtype=np.uint32)
            first = band.first_row // n
            colour[first : first + count // n] = (2 * sums + n * n) // (2 * n * n)

    def _bands(self, step: int) -> Iterator[Band]:
        """Yield the drawn bands of the image, of a multiple of ``step`` rows each."""
        width, height = self._size
        pixels = max(
            BAND_PIXELS, min(PIXELS_OF_TRIANGLE * len(self._bodies.triangles), MOST_PIXELS)
        )
        rows = min(max(pixels // width // step, 1) * step, height)
        depths = np.empty((rows, width))
        owners = np.empty((rows, width), np.int32)
        facets = np.empty_like(owners)
        bodies = self._bodies
        for first in range(0, height, rows):
            count = min(rows, height - first)
            band = Band(first, depths[:count], owners[:count], facets[:count])
            draw_band(
                *(self._order, bodies.kinds, bodies.shapes, *self._poses, self._windows),
                *(self._nearest, bodies.triangle_starts, bodies.triangles, self._p_CVs),
                *(self._view, self._slopes, band),
            )
            yield band

    def _neighbours(self) -> tuple[NDArray[np.int32], Floats, Floats]:
        """Return room for owners of the row above, normals of two rows, and a row's light."""
        width = self._size[0]
        return np.full(width, -1, np.int32), np.zeros((2, 3, width)), np.empty(width)

    def _write_colours(
        self,
        band: Band,
        look: Look,
        neighbours: tuple[NDArray[np.int32], Floats, Floats],
        out: NDArray[np.uint8],
    ) -> None:
        bodies = self._bodies
        write_colours(
            *(band, self._view, self._slopes, bodies.kinds, bodies.shapes, *self._poses),
            *(bodies.triangles, self._p_CVs, bodies.colours, bodies.facet_colours),
            *(look.background, look.edges, *neighbours, out),
        )
