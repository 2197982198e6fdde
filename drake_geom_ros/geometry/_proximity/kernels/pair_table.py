"""Pair table: one row for each unordered pair of shape types.

A row has the kernel, its method and its worst error. It is the only source for the look-up of the
engine, the table of docs/certificates.md, the accuracy tests and the "not supported" text. The
reason why each row is certified stands in docs/generate_certificates.py.
The lower type number is A. Solids, whose signed distance does not follow from a support function,
have a table of their own, and so do sensed maps: there the kernel is that of one cell, a box or a
ball, and ``OVER_MAP_KERNEL`` loops over the cells.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    OCCUPIED_CELLS,
    POINT_CLOUD,
    SOLID,
    SPHERE,
    Method,
)

SHAPE_NAMES = {
    SPHERE: 'Sphere',
    BOX: 'Box',
    CAPSULE: 'Capsule',
    CYLINDER: 'Cylinder',
    ELLIPSOID: 'Ellipsoid',
    HALF_SPACE: 'HalfSpace',
    CONVEX: 'Convex',
    SOLID: 'Mesh',  # a solid that is not convex; other meshes count as Convex
    OCCUPIED_CELLS: 'OccupiedCells',
    POINT_CLOUD: 'PointCloud',
}
TYPE_COUNT = 1 + max(SHAPE_NAMES)

_KERNELS = 'drake_geom_ros.geometry._proximity.kernels'


def load_kernel(name: str) -> Any:
    """Import and return the kernel ``folder.module.function``, only when a scene needs it."""
    module, function = name.rsplit('.', 1)
    return getattr(import_module(f'{_KERNELS}.{module}'), function)


@dataclass(frozen=True)
class PairRow:
    """Computation of the signed distance of one unordered pair of shape types."""

    type_a: int
    type_b: int
    kernel: str  # ``folder.module.function`` under ``kernels``
    method: Method
    worst_error: float  # [m] for bodies of about 0.2 m, kept true by test/accuracy

    @property
    def is_of_map(self) -> bool:
        """True if the kernel answers for one cell of B, or of both."""
        return self.type_b > SOLID

    @property
    def has_plain_overlap(self) -> bool:
        """True if ``PLAIN_OVERLAP_KERNEL`` can detect an overlap without its depth."""
        return self.kernel == _SOLIDS and not self.is_of_map

    def load_kernel(self) -> Any:
        """Import and return the kernel of the row."""
        return load_kernel(self.kernel)


CLOSED, ITERATIVE, TRIANGLES, *_ = Method
_CORES = 'convex.pairs.signed_distance_of_cores'
BY_PAIR_KERNEL = 'closed_forms.to_points.by_pair_kernel'
_TO_MAP = 'sensed.to_points.to_map'
BY_ADDRESS = (BY_PAIR_KERNEL, _TO_MAP)  # point kernels that call the pair kernel of a ball
_SOLIDS = 'solids.pairs.signed_distance_to_solid'
HULLS_KERNEL = _CORES  # for the hull of a solid beside any core or hull
PLAIN_OVERLAP_KERNEL = 'solids.plain_overlap.plain_overlap'

PAIR_TABLE = (
    PairRow(SPHERE, SPHERE, 'closed_forms.spheres.sphere_sphere', CLOSED, 1e-14),
    PairRow(SPHERE, BOX, 'closed_forms.spheres.sphere_box', CLOSED, 1e-14),
    PairRow(SPHERE, CAPSULE, 'closed_forms.spheres.sphere_capsule', CLOSED, 1e-14),
    PairRow(SPHERE, CYLINDER, 'closed_forms.spheres.sphere_cylinder', CLOSED, 1e-14),
    PairRow(SPHERE, ELLIPSOID, 'closed_forms.spheres.sphere_ellipsoid', CLOSED, 1e-14),
    PairRow(SPHERE, HALF_SPACE, 'closed_forms.spheres.sphere_half_space', CLOSED, 1e-14),
    PairRow(SPHERE, CONVEX, _CORES, ITERATIVE, 1e-12),
    PairRow(BOX, BOX, 'closed_forms.boxes.box_box', CLOSED, 1e-14),
    PairRow(BOX, CAPSULE, 'closed_forms.segments.box_capsule', CLOSED, 1e-14),
    PairRow(BOX, CYLINDER, _CORES, ITERATIVE, 1e-12),
    PairRow(BOX, ELLIPSOID, _CORES, ITERATIVE, 1e-12),
    PairRow(BOX, HALF_SPACE, 'closed_forms.half_spaces.box_half_space', CLOSED, 1e-14),
    PairRow(BOX, CONVEX, _CORES, ITERATIVE, 1e-12),
    PairRow(CAPSULE, CAPSULE, 'closed_forms.segments.capsule_capsule', CLOSED, 1e-14),
    PairRow(CAPSULE, CYLINDER, _CORES, ITERATIVE, 1e-12),
    PairRow(CAPSULE, ELLIPSOID, _CORES, ITERATIVE, 1e-11),
    PairRow(CAPSULE, HALF_SPACE, 'closed_forms.half_spaces.capsule_half_space', CLOSED, 1e-14),
    PairRow(CAPSULE, CONVEX, _CORES, ITERATIVE, 1e-12),
    PairRow(CYLINDER, CYLINDER, _CORES, ITERATIVE, 1e-12),
    PairRow(CYLINDER, ELLIPSOID, _CORES, ITERATIVE, 1e-12),
    PairRow(CYLINDER, HALF_SPACE, 'closed_forms.half_spaces.cylinder_half_space', CLOSED, 1e-14),
    PairRow(CYLINDER, CONVEX, _CORES, ITERATIVE, 1e-11),
    PairRow(ELLIPSOID, ELLIPSOID, _CORES, ITERATIVE, 1e-12),
    PairRow(ELLIPSOID, HALF_SPACE, 'closed_forms.half_spaces.ellipsoid_half_space', CLOSED, 1e-14),
    PairRow(ELLIPSOID, CONVEX, _CORES, ITERATIVE, 1e-11),
    PairRow(HALF_SPACE, CONVEX, 'closed_forms.half_spaces.half_space_convex', CLOSED, 1e-12),
    PairRow(CONVEX, CONVEX, _CORES, ITERATIVE, 1e-12),
)

# The worst error is that of separated solids; overlapping ones have an interval, given by
# ``error_bound``.
SOLID_TABLE = (
    PairRow(SPHERE, SOLID, _SOLIDS, TRIANGLES, 1e-14),
    PairRow(BOX, SOLID, _SOLIDS, TRIANGLES, 1e-12),
    PairRow(CAPSULE, SOLID, _SOLIDS, TRIANGLES, 1e-12),
    PairRow(CYLINDER, SOLID, _SOLIDS, TRIANGLES, 1e-11),
    PairRow(ELLIPSOID, SOLID, _SOLIDS, TRIANGLES, 1e-11),
    PairRow(HALF_SPACE, SOLID, 'closed_forms.half_spaces.half_space_convex', CLOSED, 1e-12),
    PairRow(CONVEX, SOLID, _SOLIDS, TRIANGLES, 1e-12),
    PairRow(SOLID, SOLID, _SOLIDS, TRIANGLES, 1e-12),
)
# The kernel is that of one cell: a box of OccupiedCells, a ball of a PointCloud. The worst error
# is that of the nearest cell; overlapping pairs have an interval, given by ``error_bound``.
OVER_MAP_KERNEL = 'sensed.pairs.over_map'
_OF_CELL = {OCCUPIED_CELLS: BOX, POINT_CLOUD: SPHERE}
_ROW_OF_PAIR = {tuple(sorted((row.type_a, row.type_b))): row for row in PAIR_TABLE + SOLID_TABLE}


def _row_of_map(type_a: int, type_b: int) -> PairRow:
    """Return the row of a map B: that of its cells against A, or against cells of A."""
    row = _ROW_OF_PAIR[tuple(sorted((_OF_CELL.get(type_a, type_a), _OF_CELL[type_b])))]
    return replace(row, type_a=type_a, type_b=type_b)


MAP_TABLE = tuple(
    _row_of_map(a, b) for b in (OCCUPIED_CELLS, POINT_CLOUD) for a in SHAPE_NAMES if a <= b
)
ALL_ROWS = PAIR_TABLE + SOLID_TABLE + MAP_TABLE

# Kernels for many points and one shape.
POINT_KERNELS = {
    SPHERE: 'closed_forms.to_points.to_sphere',
    BOX: 'closed_forms.to_points.to_box',
    CAPSULE: 'closed_forms.to_points.to_capsule',
    CYLINDER: 'closed_forms.to_points.to_cylinder',
    ELLIPSOID: 'closed_forms.to_points.to_ellipsoid',
    HALF_SPACE: 'closed_forms.to_points.to_half_space',
    CONVEX: BY_PAIR_KERNEL,
    SOLID: 'solids.to_points.to_solid',
    OCCUPIED_CELLS: _TO_MAP,
    POINT_CLOUD: _TO_MAP,
}

# Index in ALL_ROWS by type_a * TYPE_COUNT + type_b, the lower type first; -1 for none.
ROW_OF_TYPES = [-1] * TYPE_COUNT**2
for _number, _row in enumerate(ALL_ROWS):
    ROW_OF_TYPES[_row.type_a * TYPE_COUNT + _row.type_b] = _number


def unsupported(type_a: int, type_b: int) -> str:
    """Return the reason why two shape types have no signed distance, for an error message."""
    a, b = sorted((type_a, type_b))
    if a == b == HALF_SPACE:
        return 'two half spaces have no signed distance: they always overlap without bound'
    return (
        f'no kernel answers for {SHAPE_NAMES[a]} against {SHAPE_NAMES[b]}; the pairs that are '
        'supported stand in drake_geom_ros/geometry/_proximity/kernels/pair_table.py'
    )
