"""Writes docs/certificates.md from the pair table: python docs/generate_certificates.py."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from bench.pages import table
from drake_geom_ros.geometry._proximity.kernels.pair_table import (
    ALL_ROWS,
    OVER_MAP_KERNEL,
    PAIR_TABLE,
    SHAPE_NAMES,
    PairRow,
)
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CONVEX, CYLINDER

TARGET = Path(__file__).resolve().parent / 'certificates.md'
_INTRODUCTION = """# Why each answer is certified

Generated from the pair table by `python docs/generate_certificates.py`; a test keeps it up to
date.

Every answer satisfies `|distance - truth| <= error_bound`. How depends on the method:

- A *closed form* is exact but for rounding, and the bound covers rounding.
- An *iterative* answer is enclosed. Two points bound the distance from above, planes or faces
  bound it from below, and `error_bound` covers the gap between both and rounding.

## Worst errors

The worst error [m] that tests allow at accuracy level `exact`, for bodies of about 0.2 m, from
0.2 m apart to 8 cm deep (`test/geometry/_proximity/kernels/test_pair_table.py`). A mesh counts as
Convex unless it is a solid.

{table}

## Reasons

The sections below give the reason for each pair. In them, Mesh is a solid that is not convex. The
kernel at the end of each section has the proof. Some words first:

- The *Minkowski difference* of A and B is the set of all differences of a point of A and a point
  of B. It contains the origin where the bodies overlap, and the depth is the distance from the
  origin to its boundary.
- The *width* along a direction is the length of the translation that separates the bodies along
  it. The depth is the smallest width.
"""


class Reason(NamedTuple):
    """Why the error bound of some pairs holds, as a section of the page."""

    title: str
    text: str


_ROUNDING = 'The error bound covers rounding alone.'
_APART = """\
- **Apart**: two points, one of each body, bound the distance from above. An empty slab between two
  parallel planes bounds it from below."""
_SURFACE = """\
- **Overlapping**: the width along the normal bounds the depth from above. A closed surface through
  points of the Minkowski difference bounds it from below, by the smallest offset of its faces from
  the origin."""
_REASONS = {
    'closed_forms.spheres': Reason(
        'A sphere and a primitive',
        f"""\
The signed distance of the sphere's centre to the other shape has a closed form. The kernel
subtracts the radius. {_ROUNDING} It grows with the sizes and the distance.""",
    ),
    'closed_forms.boxes': Reason(
        'Two boxes',
        f"""\
- **Overlapping**: the depth is the smallest of 15 widths, along the normals of all facets that
  the Minkowski difference can have. Each width is an upper bound of the depth by itself.
- **Apart**: the distance is the smallest of 24, one for each edge of a box to the other box.

Crossed edges that are parallel are skipped. Nothing is lost: they give no direction that a face
does not give. {_ROUNDING}""",
    ),
    'closed_forms.segments': Reason(
        'A capsule and a capsule or a box',
        f"""\
A capsule is a segment with a radius, and a segment is a box without width and depth.

- **Apart**: the squared distance is a convex function of the position along the segment. Its
  slope is piecewise linear, so its root has a closed form.
- **Overlapping**: the signed distance is the largest of six separations, along the faces of the
  box and across its edges and the segment. Each is a bound by itself.

{_ROUNDING}""",
    ),
    'closed_forms.half_spaces': Reason(
        'A half space',
        f"""\
The normal is that of the half space. The distance is the height of the other shape's lowest
point, which its support function gives in closed form. {_ROUNDING}""",
    ),
    'solids.pairs': Reason(
        'Solids that are not convex',
        """\
- **Apart**: two points, one of each body, bound the distance from above. Branch and bound over the
  trees of both bodies discards boxes that are farther away. These boxes are rounded outwards, and
  the nearest of them bounds the distance from below. At accuracies of 1e-5 m and more, the gap
  between their convex hulls may be that bound. Or, of two solids, discs around the triangles of a
  node replace its boxes, and the walk ends within that accuracy.
- **Overlapping**: a verified separating translation bounds the depth from above. A part of one
  body that is certainly inside the other bounds it from below. The interval may stay open. At
  accuracies of 1e-5 m and more the search begins with the translation that separates the hulls,
  and ends once the bounds are within that accuracy.""",
    ),
    'sensed.pairs': Reason(
        'Maps of cells and points',
        """\
- **Apart**: the kernel of a box or a ball certifies the distance of the nearest cell. All other
  cells are farther, by that kernel or by boxes around groups of them, which are rounded outwards.
- **Overlapping**: the deepest cell bounds the depth from below. A translation that separates the
  body from all cells bounds it from above. The interval between them may stay open.""",
    ),
}
_CORES = 'convex.pairs'
_HULLS = Reason(
    'A convex hull and any convex shape',
    f"""\
{_APART}
{_SURFACE} Directions in a cap around the minimum of the edge next to the normal need no
  face: there, the width of the hull is at least that of the edge.""",
)
_CREASES = Reason(
    'A cylinder and a box or a capsule',
    f"""\
{_APART}
- **Overlapping**: the width has minima only on the creases and faces of the Minkowski difference.
  The kernel searches the whole circle of each crease, with a lower bound for every arc. A plane
  that the search did not choose checks the result.""",
)
_BOX_AND_ELLIPSOID = Reason(
    'A box and an ellipsoid',
    f"""\
{_APART}
{_SURFACE} So does the sum of the depths of a common point in both bodies, by closed forms.""",
)
_ROUND_CORES = Reason(
    'Two cylinders; an ellipsoid and a capsule, cylinder or ellipsoid',
    f"""\
{_APART}
{_SURFACE} So does the sum of the depths of a common point in both bodies. Where a ring of
  directions is almost as good as the best one, arcs and half planes through its axis replace the
  surface, with a lower bound for each.""",
)


def kernel_module(row: PairRow) -> str:
    """Return the module under ``kernels`` that answers for a pair, as ``folder.module``."""
    return (OVER_MAP_KERNEL if row.is_of_map else row.kernel).rpartition('.')[0]


def reason_of(row: PairRow) -> Reason:
    """Return why the error bound of a row holds; KeyError for a kernel without a reason."""
    module = kernel_module(row)
    if module != _CORES:
        return _REASONS[module]
    pair = {row.type_a, row.type_b}
    if CONVEX in pair:
        return _HULLS
    if CYLINDER in pair and pair & {BOX, CAPSULE}:
        return _CREASES
    return _BOX_AND_ELLIPSOID if BOX in pair else _ROUND_CORES


def certificates() -> str:
    """Return the text of the page, with a section for pairs that are certified alike."""
    sections: dict[tuple[str, Reason], list[str]] = {}
    for row in ALL_ROWS:
        pair = f'{SHAPE_NAMES[row.type_a]} and {SHAPE_NAMES[row.type_b]}'
        sections.setdefault((kernel_module(row), reason_of(row)), []).append(pair)
    parts = [_INTRODUCTION.replace('{table}', worst_errors())]
    for (module, reason), pairs in sections.items():
        parts.append(
            f'### {reason.title}\n\n'
            f'{reason.text}\n\n'
            f'Kernel: `kernels/{module.replace(".", "/")}.py`. Pairs: {"; ".join(pairs)}.\n'
        )
    return '\n'.join(parts)


def worst_errors() -> str:
    """Return the table of methods and worst errors."""
    rows = [
        (
            SHAPE_NAMES[row.type_a],
            SHAPE_NAMES[row.type_b],
            row.method.words,
            f'{row.worst_error:.0e}',
        )
        for row in PAIR_TABLE
    ]
    return table(('A', 'B', 'method', 'worst error [m]'), rows).rstrip()


if __name__ == '__main__':
    TARGET.write_text(certificates())
