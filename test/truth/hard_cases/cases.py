"""The catalogue of hard cases: what stands in ``catalogue``, as objects.

A file is one family. Lengths are metres, positions and normals are in World::

    {"id": "H03", "source": "fcl#127", "about": "sphere beside a box",
     "a": {"kind": "Sphere", "size": [1.0], "p": [0, 0, 0]},
     "b": {"kind": "Box", "size": [10.0, 2.0, 10.0], "p": [0, 5, 3]},
     "distance": 3.0, "tolerance": 1e-15,
     "normals": [[0, -1, 0]], "witnesses": [[0, 1, 0], [0, 4, 0]]}

``size`` is what the shape's constructor takes, of a Convex the vertices (n, 3). A Solid is a mesh
that counts as the body within its surface: it has ``triangles`` (m, 3) of its vertices too. ``R``
is the rotation by rows, left out where it is the identity. ``distance`` is right within
``tolerance``. ``normals`` are the acceptable nhat_BA_W, null: any that attains the distance;
``witnesses`` p_WCa and p_WCb, null: any on the surfaces that span it.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.math.array_types import Floats
from truth.tolerances import EPS

CATALOGUE = Path(__file__).resolve().parent / 'catalogue'
PEERS_TODAY = CATALOGUE / 'peers_today.json'


@dataclass(frozen=True, eq=False)
class Case(Pair):
    """Two bodies and what is true of them."""

    distance: float
    tolerance: float
    normals: Floats | None = None
    witnesses: Floats | None = None
    id: str = ''
    family: str = ''
    source: str = ''
    about: str = ''

    def swapped(self) -> Case:
        """Return the case with A and B exchanged."""
        return replace(
            super().swapped(),
            normals=None if self.normals is None else -self.normals,
            witnesses=None if self.witnesses is None else self.witnesses[::-1],
        )

    def moved(self, R: Floats, p: Floats) -> Case:
        """Return the case after a rigid motion of World, whose rounding its tolerance covers."""
        rounding = 4.0 * EPS * (self.extent + float(np.abs(p).max()) + self.away)
        return replace(
            super().moved(R, p),
            tolerance=self.tolerance + rounding,
            normals=None if self.normals is None else self.normals @ R.T,
            witnesses=None if self.witnesses is None else self.witnesses @ R.T + p,
        )

    def scaled(self, s: float) -> Case:
        """Return the case with all lengths multiplied by a power of two, which rounds nothing."""
        return replace(
            super().scaled(s),
            distance=s * self.distance,
            tolerance=s * self.tolerance,
            witnesses=None if self.witnesses is None else s * self.witnesses,
        )


def families() -> tuple[str, ...]:
    """Return the names of the families that are stored, sorted."""
    return tuple(sorted(path.stem for path in CATALOGUE.glob('*.json') if path != PEERS_TODAY))


def load(family: str | None = None) -> list[Case]:
    """Return the cases of a family, or all."""
    chosen = families() if family is None else (family,)
    return [
        case_of(entry, name)
        for name in chosen
        for entry in json.loads((CATALOGUE / f'{name}.json').read_text())
    ]


def case_of(entry: dict[str, Any], family: str) -> Case:
    """Return the case of an entry of a catalogue file."""
    normals, witnesses = (
        None if entry.get(key) is None else np.array(entry[key], dtype=float)
        for key in ('normals', 'witnesses')
    )
    return Case(
        body_of(entry['a']),
        body_of(entry['b']),
        float(entry['distance']),
        float(entry['tolerance']),
        normals,
        witnesses,
        family=family,
        **{key: entry[key] for key in ('id', 'source', 'about')},
    )


def body_of(entry: dict[str, Any]) -> Body:
    """Return the body of an entry."""
    R = np.array(entry.get('R', np.eye(3)), dtype=float).reshape(3, 3)
    size = tuple(tuple(v) if isinstance(v, list) else float(v) for v in entry['size'])
    triangles = tuple(map(tuple, entry.get('triangles', ())))
    return Body(entry['kind'], size, R, np.array(entry['p'], dtype=float), triangles)


def entry_of(case: Case) -> dict[str, Any]:
    """Return the entry that ``case_of`` reads, with full digits."""
    return {
        'id': case.id,
        'source': case.source,
        'about': case.about,
        'a': _entry(case.a),
        'b': _entry(case.b),
        'distance': case.distance,
        'tolerance': float(f'{case.tolerance:.1e}') * 1.1,
        'normals': None if case.normals is None else case.normals.tolist(),
        'witnesses': None if case.witnesses is None else case.witnesses.tolist(),
    }


def _entry(body: Body) -> dict[str, Any]:
    entry: dict[str, Any] = {'kind': body.kind, 'size': body.size}
    if body.triangles:
        entry['triangles'] = body.triangles
    if not np.array_equal(body.R, np.eye(3)):
        entry['R'] = body.R.ravel().tolist()
    return {**entry, 'p': body.p.tolist()}


def text_of(cases: list[Case]) -> str:
    """Return the text of a catalogue file: a case in four lines."""
    return '[\n' + ',\n\n'.join(_lines(entry_of(case)) for case in cases) + '\n]\n'


def _lines(entry: dict[str, Any]) -> str:
    groups = (('id', 'source', 'about'), ('a',), ('b',))
    rest = tuple(key for key in entry if key not in ('id', 'source', 'about', 'a', 'b'))
    lines = [
        ', '.join(f'{json.dumps(key)}: {json.dumps(entry[key])}' for key in group)
        for group in (*groups, rest)
    ]
    return ' {' + ',\n  '.join(lines) + '}'
