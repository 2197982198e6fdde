"""The cell of the storm: two robots of loose bodies, what stands, and what rules there may be."""

from __future__ import annotations

import random
from typing import Any, NamedTuple

from drake_geom_ros.geometry import FramePoseVector, GeometryId, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene

STALE_AFTER = 0.5  # [s]
SHAPES = {
    'left': (
        '{type: sphere, radius: 0.06}',
        '{type: box, size: [0.1, 0.14, 0.2]}',
        '{type: capsule, radius: 0.04, length: 0.2}',
    ),
    'right': (
        '{type: ellipsoid, semi_axes: [0.05, 0.08, 0.12]}',
        '{type: cylinder, radius: 0.07, length: 0.15}',
        '{type: box, size: [0.2, 0.05, 0.05]}',
    ),
}
STANDING = {
    'post': '{type: cylinder, radius: 0.05, length: 0.8}',
    'table': '{type: box, size: [1, 1, 0.05]}, pose: {position: [0, 0, -0.35]}',
}
NAMES = [f'{source}::f{k}' for source, shapes in SHAPES.items() for k in range(len(shapes))]
# What sets of rules may be, and the bodies that each stands for.
SETS: dict[str, frozenset[str]] = {
    'left': frozenset(NAMES[:3]),
    'right': frozenset(NAMES[3:]),
    'cell': frozenset(STANDING),
    **{name: frozenset([name]) for name in NAMES},
    'post': frozenset(['post']),
}
BODIES = frozenset([*NAMES, *STANDING])


class Rule(NamedTuple):
    """A rule, by the bodies that it is about."""

    name: str
    sets: tuple[str, str]  # of SETS; the second may be empty: all that is not of the first
    level: int  # 1: warn, 2: slow, 3: stop
    enter: float  # [m]
    leave: float  # [m]
    hold: float = 0.0  # [s]
    enter_after: float = 0.0  # [s]
    when_stale: str = ''
    min_time_to_contact: float = 0.0  # [s]

    @property
    def enters_when_stale(self) -> bool:
        """Whether a stale pose enters it."""
        return self.when_stale == 'enter' or (not self.when_stale and self.level != 1)

    def pairs(self) -> frozenset[frozenset[str]]:
        """Return the pairs of bodies that it is about, two of what stands left aside."""
        a = SETS[self.sets[0]]
        b = SETS[self.sets[1]] if self.sets[1] else BODIES - a
        found = {frozenset((x, y)) for x in a for y in b if x != y}
        return frozenset(pair for pair in found if not pair <= set(STANDING))

    def fields(self) -> dict[str, Any]:
        """Return the fields of its message."""
        b = [self.sets[1]] if self.sets[1] else []
        return {
            **{name: getattr(self, name) for name in ('name', 'level', 'enter', 'leave')},
            **{name: getattr(self, name) for name in ('hold', 'enter_after', 'when_stale')},
            'min_time_to_contact': self.min_time_to_contact,
            'set_a': [self.sets[0]],
            'set_b': b,
        }


# Says how fast to go, at the end of each decision: so it is known when these were made.
PULSE = Rule('pulse', ('left', 'right'), 2, 0.05, 0.1)


def drawn_rule(number: int, rng: random.Random) -> Rule:
    """Return a rule that some pair may enter."""
    while True:
        a, b = rng.choice(list(SETS)), rng.choice(['', *SETS])
        enter = rng.uniform(0.0, 0.2)
        times = [rng.choice([0.0, 0.0, 0.05, 0.3]) for _ in range(2)]
        rule = Rule(
            *(f'rule {number}', (a, b), rng.choice([1, 2, 3]), enter),
            *(enter + rng.uniform(0.01, 0.1), *times, rng.choice(['', '', 'enter', 'keep'])),
            rng.choice([0.0, 0.0, 0.0, 0.05, 0.2]),
        )
        if rule.pairs():
            return rule


def scene_text() -> str:
    """Return the scene file; its frames never had a pose."""
    lines = ['name: cell', 'sources: [left, right]', 'frames:']
    for source, shapes in SHAPES.items():
        lines += [f'- {{name: f{k}, source: {source}, static: false}}' for k in range(len(shapes))]
    lines.append('geometries:')
    for source, shapes in SHAPES.items():
        lines += [
            f'- {{name: g, source: {source}, frame: f{k}, shape: {shape}}}'
            for k, shape in enumerate(shapes)
        ]
    lines += [f'- {{name: {name}, shape: {shape}}}' for name, shape in STANDING.items()]
    a, b = PULSE.sets
    lines.append('proximity_rules:')
    lines.append(
        f'- {{name: {PULSE.name}, set_a: {a}, set_b: {b}, level: slow, enter: {PULSE.enter}, '
        f'leave: {PULSE.leave}}}'
    )
    return '\n'.join(lines) + '\n'


class Bodies:
    """The bodies without any filter, asked pair by pair by the core."""

    def __init__(self) -> None:
        self._graph = SceneGraph()
        loaded = load_scene(scene_text(), self._graph)
        self._frames = {f'{s}::{f}': id for (s, f), id in loaded.frames.items()}
        self._ids: dict[str, GeometryId] = {}
        for (source, frame, geometry), id in loaded.geometries.items():
            self._ids[geometry if frame == 'world' else f'{source}::{frame}'] = id
        self._context = self._graph.CreateSharedContext(partial=True)
        self._query = self._graph.get_query_output_port().Eval(self._context)

    def pose(self, places: dict[str, RigidTransform]) -> None:
        """Put bodies somewhere."""
        poses = {self._frames[name]: X_WF for name, X_WF in places.items()}
        self._context.UpdateFramePoses(FramePoseVector(poses))

    def distance(self, pair: frozenset[str]) -> tuple[float, float]:
        """Return the signed distance of a pair and its error bound [m], at level exact."""
        a, b = (self._ids[name] for name in pair)
        found = self._query.ComputeSignedDistancePairClosestPoints(a, b)
        return found.distance, found.error_bound


def body_of(full_name: str) -> str:
    """Return the body of a geometry, `source::frame/geometry`."""
    frame, _, geometry = full_name.rpartition('/')
    return geometry if frame == 'cell::world' else frame
