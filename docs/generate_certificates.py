"""Writes docs/certificates.md from the pair table: python docs/generate_certificates.py."""

from __future__ import annotations

from pathlib import Path

from drake_geom_ros.geometry._proximity.pair_table import ALL_ROWS, SHAPE_NAMES

TARGET = Path(__file__).resolve().parent / 'certificates.md'
_INTRODUCTION = """# Why each answer is certified

Made from the pair table by `python docs/generate_certificates.py`; a test holds it current. Every
result promises `|distance - truth| <= error_bound`. This page says, for each pair of shapes, what
makes that true; the proofs stand in the kernels that are named.
A Mesh here is a solid that is not convex; any other mesh counts as Convex.
"""


def certificates() -> str:
    """Return the text of the page: pairs that are certified alike stand together."""
    alike: dict[tuple[str, str], list[str]] = {}
    for row in ALL_ROWS:
        pair = f'{SHAPE_NAMES[row.type_a]} and {SHAPE_NAMES[row.type_b]}'
        alike.setdefault((row.kernel.rpartition('.')[0], row.certificate), []).append(pair)
    parts = [_INTRODUCTION]
    for (module, reason), pairs in alike.items():
        parts.append(
            f'## {", ".join(pairs)}\n\n{reason} (`kernels/{module.replace(".", "/")}.py`)\n'
        )
    return '\n'.join(parts)


if __name__ == '__main__':
    TARGET.write_text(certificates())
