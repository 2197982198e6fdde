"""Map files by suffix: cells (``.bt``, ``.ot``) or points."""

from __future__ import annotations

import io
import os
import stat
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy_format

from drake_geom_ros.common.stand_ins import stand_in
from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.geometry.meshes.ply_points import ply_points
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.sensed_maps.cells import Cells, MapError
from drake_geom_ros.sensed_maps.octree_file import octree_file, parse_octree_file
from drake_geom_ros.sensed_maps.pcd_file import MOST_POINTS, parse_pcd, pcd_file

CELL_SUFFIXES = ('.bt', '.ot')
POINT_SUFFIXES = ('.pcd', '.ply', '.xyz', '.npy')
MAP_SUFFIXES = (*CELL_SUFFIXES, *POINT_SUFFIXES)
_MOST_BYTES = 512_000_000


@dataclass(frozen=True)
class MapFile:
    """Contents of a map file: finite points (n, 3) [m], which are centres if it has ``cells``.

    ``left_out`` counts the points that were not finite, as in organised clouds.
    """

    points: Floats
    cells: Cells | None = None
    left_out: int = 0

    def as_cells(self, resolution: float | None = None) -> Cells:
        """Return the contents as cells of a resolution [m]; None: that of its cells.

        Raises MapError for None if the file has points, and for a resolution finer than its cells.
        """
        if self.cells is None:
            if resolution is None:
                raise MapError('points become cells of a resolution [m], which was not given')
            return Cells.of_points(self.points, resolution)
        if resolution is None or resolution == self.cells.resolution:
            return self.cells
        return self.cells.coarser(resolution)


def read_map(path: str | os.PathLike[str]) -> MapFile:
    """Return the contents of a map file by its suffix; raises MapError with file and reason.

    The size of the file is checked before memory is allocated for the sizes in its header.
    """
    suffix = Path(path).suffix.lower()
    try:
        if suffix not in MAP_SUFFIXES:
            raise MapError(f'its suffix is {suffix!r}; {", ".join(MAP_SUFFIXES)} are read')
        data = _content(Path(path))
        if reason := stand_in(data):
            raise MapError(reason)
        if suffix in CELL_SUFFIXES:
            cells = parse_octree_file(data, suffix)
            return MapFile(cells.centres(), cells)
        return _finite(_POINTS[suffix](data))
    except OSError as error:
        raise MapError(f'{str(path)!r} cannot be read: {error.strerror}') from None
    except GeometryError as error:
        raise MapError(f'{str(path)!r} cannot be read: {error}') from None


def map_bytes(read: MapFile, suffix: str, resolution: float | None = None) -> bytes:
    """Return the content of a map file by suffix; with a ``resolution`` [m], of such cells.

    Cells become their centres in formats of points. Raises MapError for contents that the format
    cannot hold.
    """
    if suffix == '.bt':
        return octree_file(read.as_cells(resolution))
    if suffix not in _WRITERS:
        suffixes = ', '.join(('.bt', *_WRITERS))
        raise MapError(f'a map is not written as {suffix!r}; {suffixes} are')
    points = read.points if resolution is None else read.as_cells(resolution).centres()
    return _WRITERS[suffix](points)


def _content(path: Path) -> bytes:
    with path.open('rb') as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise MapError('it is no plain file')
        if status.st_size > _MOST_BYTES:
            raise MapError(f'it has {status.st_size} bytes; at most {_MOST_BYTES} are read')
        return file.read(status.st_size)


def _finite(points: Floats) -> MapFile:
    if len(points) > MOST_POINTS:
        raise MapError(f'it has {len(points)} points; at most {MOST_POINTS} are read')
    is_finite = np.isfinite(points).all(axis=1)
    left_out = int(len(points) - np.count_nonzero(is_finite))
    return MapFile(points[is_finite] if left_out else points, left_out=left_out)


def _parse_xyz(data: bytes) -> Floats:
    """Return the points of a text with three numbers a line; further ones are ignored."""
    try:
        return np.loadtxt(io.BytesIO(data), usecols=(0, 1, 2), ndmin=2, comments=('#', '//'))
    except ValueError as error:
        raise MapError(f'a line must begin with three numbers: {error}') from None


def _parse_npy(data: bytes) -> Floats:
    """Return the points of an array (n, 3) of floats; MapError for other arrays."""
    stream = io.BytesIO(data)
    readers = {(1, 0): npy_format.read_array_header_1_0, (2, 0): npy_format.read_array_header_2_0}
    try:
        version = npy_format.read_magic(stream)
        if version not in readers:
            raise ValueError(f'its version is {version}')
        shape, in_columns, kind = readers[version](stream)
    except (ValueError, SyntaxError, TypeError) as error:
        raise MapError(f'it has no header of a NumPy array: {error}') from None
    is_table = len(shape) == 2 and shape[0] >= 0 and shape[1] == 3
    if not is_table or kind.kind != 'f' or kind.itemsize > 8:
        raise MapError(f'it is an array {shape} of {kind}; it must be (n, 3) of floats')
    needed = shape[0] * 3 * kind.itemsize
    body = memoryview(data)[stream.tell() :]
    if len(body) < needed:
        raise MapError(f'it is truncated: {len(body)} bytes of data of {needed}')
    if len(body) > needed:
        raise MapError(
            f'{len(body) - needed} bytes follow its array {shape} of {kind}; it must hold nothing '
            'else'
        )
    table = np.frombuffer(body, kind, shape[0] * 3)
    rows = table.reshape(3, -1).T if in_columns else table.reshape(-1, 3)
    with np.errstate(invalid='ignore'):
        return np.ascontiguousarray(rows, dtype=np.float64)


def _ply_file(points: Floats) -> bytes:
    header = (
        f'ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n'
        'property double x\nproperty double y\nproperty double z\nend_header\n'
    )
    return header.encode() + points.astype('<f8').tobytes()


def _xyz_file(points: Floats) -> bytes:
    return ''.join(f'{x!r} {y!r} {z!r}\n' for x, y, z in points.tolist()).encode()


def _npy_file(points: Floats) -> bytes:
    stream = io.BytesIO()
    np.save(stream, points, allow_pickle=False)
    return stream.getvalue()


_POINTS: dict[str, Callable[[bytes], Any]] = {
    '.pcd': parse_pcd,
    '.ply': lambda data: ply_points(data, 'the file'),
    '.xyz': _parse_xyz,
    '.npy': _parse_npy,
}
_WRITERS: dict[str, Callable[[Floats], bytes]] = {
    '.pcd': pcd_file,
    '.ply': _ply_file,
    '.xyz': _xyz_file,
    '.npy': _npy_file,
}
