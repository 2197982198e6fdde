"""A scene of names, measurements of it by hand, and monitors of rules about it."""

import itertools

import numpy as np

from drake_geom_ros.common.geometry_names import GeometryNames
from drake_geom_ros.geometry import CandidatePairs
from drake_geom_ros.proximity_rules import (
    Measured,
    NamedGeometries,
    Poses,
    ProximityRule,
    RuleMonitor,
    ScenePairs,
)

NAMES = [
    GeometryNames('left', 'hand', 'finger', False),
    GeometryNames('left', 'hand', 'palm', False),
    GeometryNames('left', 'arm', 'tube', False),
    GeometryNames('right', 'hand', 'palm', False),
    GeometryNames('room', 'world', 'table', True),
    GeometryNames('room', 'world', 'wall', True),
]
PATTERNS = ['left', 'right', 'room', 'left::hand', 'hand', '*/palm', 'table', '*', 'arm/tube']
FRESH = Poses(np.zeros(6, bool), np.zeros(6, bool))


def scene(filtered=(), names=NAMES, first_id=11):
    n = len(names)
    reported = ~np.eye(n, dtype=bool)
    for a, b in itertools.product(range(n), repeat=2):
        same = names[a].body == names[b].body or (names[a].is_anchored and names[b].is_anchored)
        reported[a, b] &= not same and (a, b) not in filtered and (b, a) not in filtered
    every, excluded = np.arange(n), np.packbits(~reported, axis=1, bitorder='little')
    pairs = CandidatePairs(np.arange(first_id, first_id + n), every, every, every, excluded)
    return ScenePairs(NamedGeometries(names), pairs)


def measured(*pairs, speeds=None):
    """Return what a cycle saw of (a, b, distance, error bound)."""
    a, b, distance, bound = (np.array(column) for column in zip(*pairs, strict=True))
    points = np.arange(3.0 * len(pairs)).reshape(-1, 3)
    speeds = None if speeds is None else np.array(speeds)
    return Measured(11 + a, 11 + b, distance.astype(float), bound, points, -points, speeds)


NOTHING = Measured(
    *np.empty((2, 0), dtype=np.int64), *np.empty((2, 0)), *np.empty((2, 0, 3)), np.empty(0)
)


def rule(name='r', set_a=('left',), set_b=('room',), **more):
    return ProximityRule(name, set_a, set_b, **{'enter': 0.1, 'leave': 0.2, **more})


def monitor(*rules, **of_scene):
    made = RuleMonitor(scene(**of_scene))
    made.add(rules)
    return made
