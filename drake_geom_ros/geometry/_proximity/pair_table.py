"""THE table: one row an unordered pair of shape types.

Which kernel answers, by which method, and how far off it was at worst: the look-up of the engine,
the support table of the README, the accuracy tests and the "not supported" text all come from
here. The lower type number is A. Solids, whose signed distance no support function tells, have a
table of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

SHAPE_NAMES = {
    1: 'Sphere',
    2: 'Box',
    3: 'Capsule',
    4: 'Cylinder',
    5: 'Ellipsoid',
    6: 'HalfSpace',
    7: 'Convex',
    8: 'Mesh',  # as a solid that is not convex; any other counts as Convex
}
SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID, HALF_SPACE, CONVEX, SOLID = SHAPE_NAMES
TYPE_COUNT = 1 + max(SHAPE_NAMES)

CLOSED_FORM = 'closed form'
ITERATIVE = 'iterative'
TRIANGLES = 'mesh'


_KERNELS = 'drake_geom_ros.geometry._proximity.kernels'


def load_kernel(name: str) -> Any:
    """Import the kernel ``module.function``; only those that a scene needs are ever imported."""
    module, function = name.split('.')
    return getattr(import_module(f'{_KERNELS}.{module}'), function)


@dataclass(frozen=True)
class PairRow:
    """How the signed distance of one unordered pair of shape types is computed."""

    type_a: int
    type_b: int
    kernel: str  # ``module.function`` under ``kernels``
    method: str
    worst_error: float  # [m] for bodies of about 0.2 m, kept true by test/accuracy

    def load_kernel(self) -> Any:
        """Return the kernel."""
        return load_kernel(self.kernel)


_CORES = 'convex.signed_distance_of_cores'
BY_PAIR_KERNEL = 'to_points.by_pair_kernel'
_SOLIDS = 'solids.signed_distance_to_solid'

PAIR_TABLE = (
    PairRow(SPHERE, SPHERE, 'spheres.sphere_sphere', CLOSED_FORM, 1e-14),
    PairRow(SPHERE, BOX, 'spheres.sphere_box', CLOSED_FORM, 1e-14),
    PairRow(SPHERE, CAPSULE, 'spheres.sphere_capsule', CLOSED_FORM, 1e-14),
    PairRow(SPHERE, CYLINDER, 'spheres.sphere_cylinder', CLOSED_FORM, 1e-14),
    PairRow(SPHERE, ELLIPSOID, 'spheres.sphere_ellipsoid', CLOSED_FORM, 1e-14),
    PairRow(SPHERE, HALF_SPACE, 'spheres.sphere_half_space', CLOSED_FORM, 1e-14),
    PairRow(SPHERE, CONVEX, _CORES, ITERATIVE, 1e-12),
    PairRow(BOX, BOX, 'boxes.box_box', CLOSED_FORM, 1e-14),
    PairRow(BOX, CAPSULE, 'segments.box_capsule', CLOSED_FORM, 1e-14),
    PairRow(BOX, CYLINDER, _CORES, ITERATIVE, 1e-12),
    PairRow(BOX, ELLIPSOID, _CORES, ITERATIVE, 1e-12),
    PairRow(BOX, HALF_SPACE, 'half_spaces.box_half_space', CLOSED_FORM, 1e-14),
    PairRow(BOX, CONVEX, _CORES, ITERATIVE, 1e-12),
    PairRow(CAPSULE, CAPSULE, 'segments.capsule_capsule', CLOSED_FORM, 1e-14),
    PairRow(CAPSULE, CYLINDER, _CORES, ITERATIVE, 1e-12),
    PairRow(CAPSULE, ELLIPSOID, _CORES, ITERATIVE, 1e-11),
    PairRow(CAPSULE, HALF_SPACE, 'half_spaces.capsule_half_space', CLOSED_FORM, 1e-14),
    PairRow(CAPSULE, CONVEX, _CORES, ITERATIVE, 1e-12),
    PairRow(CYLINDER, CYLINDER, _CORES, ITERATIVE, 1e-12),
    PairRow(CYLINDER, ELLIPSOID, _CORES, ITERATIVE, 1e-12),
    PairRow(CYLINDER, HALF_SPACE, 'half_spaces.cylinder_half_space', CLOSED_FORM, 1e-14),
    PairRow(CYLINDER, CONVEX, _CORES, ITERATIVE, 1e-11),
    PairRow(ELLIPSOID, ELLIPSOID, _CORES, ITERATIVE, 1e-12),
    PairRow(ELLIPSOID, HALF_SPACE, 'half_spaces.ellipsoid_half_space', CLOSED_FORM, 1e-14),
    PairRow(ELLIPSOID, CONVEX, _CORES, ITERATIVE, 1e-11),
    PairRow(HALF_SPACE, CONVEX, 'half_spaces.half_space_convex', CLOSED_FORM, 1e-12),
    PairRow(CONVEX, CONVEX, _CORES, ITERATIVE, 1e-12),
)

# The worst error is that of solids that are apart; overlapping ones have an interval, which
# ``error_bound`` tells.
SOLID_TABLE = (
    PairRow(SPHERE, SOLID, _SOLIDS, TRIANGLES, 1e-14),
    PairRow(BOX, SOLID, _SOLIDS, TRIANGLES, 1e-12),
    PairRow(CAPSULE, SOLID, _SOLIDS, TRIANGLES, 1e-12),
    PairRow(CYLINDER, SOLID, _SOLIDS, TRIANGLES, 1e-11),
    PairRow(ELLIPSOID, SOLID, _SOLIDS, TRIANGLES, 1e-11),
    PairRow(HALF_SPACE, SOLID, 'half_spaces.half_space_convex', CLOSED_FORM, 1e-12),
    PairRow(CONVEX, SOLID, _SOLIDS, TRIANGLES, 1e-12),
    PairRow(SOLID, SOLID, _SOLIDS, TRIANGLES, 1e-12),
)
ALL_ROWS = PAIR_TABLE + SOLID_TABLE

# What answers for many points and one shape.
POINT_KERNELS = {
    SPHERE: 'to_points.to_sphere',
    BOX: 'to_points.to_box',
    CAPSULE: 'to_points.to_capsule',
    CYLINDER: 'to_points.to_cylinder',
    ELLIPSOID: 'to_points.to_ellipsoid',
    HALF_SPACE: 'to_points.to_half_space',
    CONVEX: BY_PAIR_KERNEL,
    SOLID: BY_PAIR_KERNEL,
}

# Number in ALL_ROWS by type_a * TYPE_COUNT + type_b, the lower type first; -1 where there is none.
ROW_OF_TYPES = [-1] * TYPE_COUNT**2
for _number, _row in enumerate(ALL_ROWS):
    ROW_OF_TYPES[_row.type_a * TYPE_COUNT + _row.type_b] = _number


def unsupported(type_a: int, type_b: int) -> str:
    """Return why two shape types have no signed distance, for an error message."""
    a, b = sorted((type_a, type_b))
    if a == b == HALF_SPACE:
        return 'two half spaces have no signed distance: they always overlap without bound'
    return (
        f'no kernel answers for {SHAPE_NAMES[a]} against {SHAPE_NAMES[b]}; the pairs that are '
        'supported stand in drake_geom_ros/geometry/_proximity/pair_table.py'
    )
