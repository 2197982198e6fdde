"""Pair table: one row for each unordered pair of shape types.

A row has the kernel, its method and its worst error. It is the only source for the look-up of the
engine, the support table of docs/certificates.md, the accuracy tests and the "not supported" text.
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


_APART = (
    'Apart, two points of the bodies bound the distance from above, and an empty slab between two '
    'planes bounds it from below. '
)
_POLYTOPE = (
    'the width along the normal bounds the depth from above, and the least offset of a closed '
    'surface of points of the Minkowski difference from below'
)
# Reasons why answers of a kernel are certified, in two sentences; for ``convex.pairs`` by pair.
_CERTIFICATES = {
    'closed_forms.spheres': (
        "The signed distance of the sphere's centre has a closed form in the frame of the other "
        'shape, and the radius is taken off it. Only rounding is in the bound, which grows with '
        'the sizes and the distance.'
    ),
    'closed_forms.boxes': (
        'Overlapping boxes are as deep as the least of 15 widths, along the normals of all facets '
        'that their Minkowski difference can have, and each bounds the depth by itself; apart, '
        'they are as far as the nearest of 24 edges from the other box. Parallel edges cross '
        'along no direction that a face has not, so leaving them out loses nothing, and only '
        'rounding is in the bound.'
    ),
    'closed_forms.segments': (
        'A capsule is a segment with a radius, and the distance to a segment is the least of a '
        'convex function of one number, whose slope is linear between the planes of faces; where '
        'both overlap it is the largest of six separations, each a bound by itself. Both are '
        'closed forms, so only rounding is in the bound.'
    ),
    'closed_forms.half_spaces': (
        'The normal is that of the half space, and the point of the other shape that is lowest '
        'along it is its support point. Both are closed forms, so only rounding is in the bound.'
    ),
    'solids.pairs': (
        'Apart, two points of the bodies bound the distance from above, and from below it is '
        'bounded by what was left out of the walk over both trees, whose boxes are rounded '
        'outwards; at accuracies of 1e-5 m and more it may be a walk over discs around the '
        'triangles of nodes, which ends where they are within it. Overlapping, a verified '
        'translation bounds the depth from above and what is certain to be inside from below: the '
        'interval between them may stay open.'
    ),
}
_HULLS = (
    f'Overlapping, {_POLYTOPE}, but for a cap around the minimum of the edge next to the normal, '
    'for the width of the hull is nowhere less than that of its edge.'
)
_CREASES = (
    'Overlapping, the width has no minimum off the creases and faces of the Minkowski difference, '
    'and the whole circle of each crease is searched with a lower bound for every arc, which a '
    'plane that the search did not choose checks.'
)
_BY_BALLS = (
    f'Overlapping, {_POLYTOPE}; so does the sum of the depths of a point in both, by closed forms.'
)
_RINGS = (
    f'Overlapping, {_POLYTOPE}, as does the sum of the depths of a point in both; where a ring of '
    'directions is almost as good, arcs and half planes through the axis with a lower bound each '
    'prove it instead.'
)


_MAPS = (
    'Apart, the nearest cell is as far as the kernel of a box or a ball certifies, and all others '
    'are farther by that kernel or by boxes around them, which are rounded outwards. Overlapping, '
    'the deepest cell bounds the depth from below and a translation that parts the body from all '
    'cells from above: the interval between them may stay open.'
)


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

    @property
    def certificate(self) -> str:
        """Reason why the error bound of an answer holds, in two sentences."""
        if self.is_of_map:
            return _MAPS
        module = self.kernel.rpartition('.')[0]
        if module in _CERTIFICATES:
            return _CERTIFICATES[module]
        pair = {self.type_a, self.type_b}
        if CONVEX in pair:
            return _APART + _HULLS
        if CYLINDER in pair and pair & {BOX, CAPSULE}:
            return _APART + _CREASES
        return _APART + (_BY_BALLS if BOX in pair else _RINGS)

    def load_kernel(self) -> Any:
        """Import and return the kernel of the row."""
        return load_kernel(self.kernel)


CLOSED, ITERATIVE, TRIANGLES, *_ = Method
_CORES = 'convex.pairs.signed_distance_of_cores'
BY_PAIR_KERNEL = 'closed_forms.to_points.by_pair_kernel'
_TO_MAP = 'sensed.to_points.to_map'
BY_ADDRESS = (BY_PAIR_KERNEL, _TO_MAP)  # point kernels that call the pair kernel of a ball
_SOLIDS = 'solids.pairs.signed_distance_to_solid'
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
