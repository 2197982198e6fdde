"""Writes docs/certificates.md from the pair table: python docs/generate_certificates.py."""

from __future__ import annotations

from pathlib import Path

from bench.pages import table
from drake_geom_ros.geometry._proximity.kernels.pair_table import (
    ALL_ROWS,
    OVER_MAP_KERNEL,
    PAIR_TABLE,
    SHAPE_NAMES,
)

TARGET = Path(__file__).resolve().parent / 'certificates.md'
_INTRODUCTION = """# Why each answer is certified

Generated from the pair table by `python docs/generate_certificates.py`; a test keeps it up to
date.

Every answer satisfies `|distance - truth| <= error_bound`, for two reasons. A *closed form* is
exact but for rounding, and the bound covers rounding. An *iterative* answer is enclosed: two
points bound the distance from above, planes or faces bound it from below, and `error_bound` is
the width of what is left. The table gives the worst error of each pair of shapes; below it, this
page gives the reason for each. The proofs are in the kernels that are named.

## Worst errors

The worst error [m] that tests allow at accuracy level `exact`, for bodies of about 0.2 m, from
0.2 m apart to 8 cm deep (`test/geometry/_proximity/kernels/test_pair_table.py`). A mesh counts as
Convex unless it is a solid.

{table}

In the reasons below, Mesh is a solid that is not convex.
"""


def certificates() -> str:
    """Return the text of the page: pairs that are certified alike stand together."""
    alike: dict[tuple[str, str], list[str]] = {}
    for row in ALL_ROWS:
        pair = f'{SHAPE_NAMES[row.type_a]} and {SHAPE_NAMES[row.type_b]}'
        kernel = OVER_MAP_KERNEL if row.is_of_map else row.kernel
        alike.setdefault((kernel.rpartition('.')[0], row.certificate), []).append(pair)
    parts = [_INTRODUCTION.replace('{table}', worst_errors())]
    for (module, reason), pairs in alike.items():
        parts.append(
            f'## {", ".join(pairs)}\n\n{reason} (`kernels/{module.replace(".", "/")}.py`)\n'
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
    return table(('A', 'B', 'method', 'worst error'), rows).rstrip()


if __name__ == '__main__':
    TARGET.write_text(certificates())
