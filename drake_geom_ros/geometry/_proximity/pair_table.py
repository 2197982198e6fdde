"""THE table: one row an unordered pair of shape types.

Which kernel answers, by which method, and how far off it was at worst: the look-up of the engine,
the support table of the README, the accuracy tests and the "not supported" text all come from
here. The lower type number is A.
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
    8: 'Mesh',
}
SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID, HALF_SPACE, CONVEX, MESH = SHAPE_NAMES
TYPE_COUNT = 1 + max(SHAPE_NAMES)

CLOSED_FORM = 'closed form'
ITERATIVE = 'iterative'


@dataclass(frozen=True)
class PairRow:
    """How the signed distance of one unordered pair of shape types is computed."""

    type_a: int
    type_b: int
    room: str  # the module under ``kernels`` that holds the kernel
    method: str
    worst_error: float  # [m] for bodies of about 0.2 m, kept true by test/accuracy

    @property
    def kernel_name(self) -> str:
        """The kernel's name, from the names of its shapes."""
        names = ('', 'sphere', 'box', 'capsule', 'cylinder', 'ellipsoid', 'half_space')
        return f'{names[self.type_a]}_{names[self.type_b]}'

    def load_kernel(self) -> Any:
        """Import the kernel; only rows that a scene has are ever imported."""
        module = import_module(f'drake_geom_ros.geometry._proximity.kernels.{self.room}')
        return getattr(module, self.kernel_name)


PAIR_TABLE = (
    PairRow(SPHERE, SPHERE, 'spheres', CLOSED_FORM, 1e-15),
    PairRow(SPHERE, BOX, 'spheres', CLOSED_FORM, 1e-15),
    PairRow(SPHERE, CAPSULE, 'spheres', CLOSED_FORM, 1e-15),
    PairRow(SPHERE, CYLINDER, 'spheres', CLOSED_FORM, 1e-15),
    PairRow(SPHERE, ELLIPSOID, 'spheres', CLOSED_FORM, 1e-15),
    PairRow(SPHERE, HALF_SPACE, 'spheres', CLOSED_FORM, 1e-15),
    PairRow(BOX, BOX, 'boxes', CLOSED_FORM, 1e-15),
    PairRow(BOX, CAPSULE, 'segments', CLOSED_FORM, 1e-15),
    PairRow(BOX, CYLINDER, 'convex', ITERATIVE, 1e-9),
    PairRow(BOX, ELLIPSOID, 'convex', ITERATIVE, 1e-9),
    PairRow(BOX, HALF_SPACE, 'half_spaces', CLOSED_FORM, 1e-15),
    PairRow(CAPSULE, CAPSULE, 'segments', CLOSED_FORM, 1e-15),
    PairRow(CAPSULE, CYLINDER, 'convex', ITERATIVE, 1e-9),
    PairRow(CAPSULE, ELLIPSOID, 'convex', ITERATIVE, 1e-9),
    PairRow(CAPSULE, HALF_SPACE, 'half_spaces', CLOSED_FORM, 1e-15),
    PairRow(CYLINDER, CYLINDER, 'convex', ITERATIVE, 1e-9),
    PairRow(CYLINDER, ELLIPSOID, 'convex', ITERATIVE, 1e-9),
    PairRow(CYLINDER, HALF_SPACE, 'half_spaces', CLOSED_FORM, 1e-15),
    PairRow(ELLIPSOID, ELLIPSOID, 'convex', ITERATIVE, 1e-9),
    PairRow(ELLIPSOID, HALF_SPACE, 'half_spaces', CLOSED_FORM, 1e-15),
)

# Row number by type_a * TYPE_COUNT + type_b, the lower type first; -1 where there is no row.
ROW_OF_TYPES = [-1] * TYPE_COUNT**2
for _number, _row in enumerate(PAIR_TABLE):
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
