"""Collision filters against pydrake's, and masking against a NumPy gather, in one run.

    python -m bench.costs.filters [geometries ...]

Every scene has one sphere a frame. A declaration is between two sets of one geometry, and of a
tenth of the scene, at random. Repetitions of the two sides take turns, so that whatever else the
machine does meets both. Without pydrake only our own numbers are printed.
"""

from __future__ import annotations

import importlib
import itertools
import sys
import time
import tracemalloc
from collections.abc import Callable
from statistics import median
from types import ModuleType
from typing import Any

import numpy as np

from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry._proximity.filters.state import FilterState

COUNTS = (200, 1000, 5000)
REPETITIONS = {200: 21, 1000: 7, 5000: 2}  # pydrake takes seconds for a removal among 5000
APPLIED = 10
HISTORIES = (60, 600, 6000)  # transient declarations
REMOVED = 20
PAIRS = 100_000


class Side:
    """One library with a scene of its own; every operation returns the seconds it took."""

    def __init__(self, package: str, count: int) -> None:
        self._geometry: ModuleType = importlib.import_module(f'{package}.geometry')
        self._identity = importlib.import_module(f'{package}.math').RigidTransform()
        self.scene_graph = self._geometry.SceneGraph()
        source = self.scene_graph.RegisterSource('bench')
        self.ids = [self._registered(source, k) for k in range(count)]
        self._manager = self.scene_graph.collision_filter_manager()

    def _registered(self, source: Any, number: int) -> Any:
        frame = self._geometry.GeometryFrame(f'frame {number}')
        frame_id = self.scene_graph.RegisterFrame(source, frame)
        instance = self._geometry.GeometryInstance(
            self._identity, self._geometry.Sphere(1.0), f'sphere {number}'
        )
        instance.set_proximity_properties(self._geometry.ProximityProperties())
        return self.scene_graph.RegisterGeometry(source, frame_id, instance)

    def sets(self, rows: list[list[int]]) -> list[Any]:
        """Return sets of geometries, given by number."""
        return [self._geometry.GeometrySet([self.ids[k] for k in numbers]) for numbers in rows]

    def seconds(self, rows: list[list[int]]) -> dict[str, float]:
        """Time each operation on the first two of four sets; in the end no filter is left.

        To make a declaration of the sets is part of it. The one removed is the first of two.
        """
        a, b, *more = self.sets(rows)
        declare, manager = self._geometry.CollisionFilterDeclaration, self._manager

        def apply() -> None:
            for _ in range(APPLIED // 2):
                manager.Apply(declare().ExcludeBetween(a, b))
                manager.Apply(declare().AllowBetween(a, b))

        taken = {'Apply': timed(apply)[0] / APPLIED}
        taken['ApplyTransient'], first = timed(
            lambda: manager.ApplyTransient(declare().ExcludeBetween(a, b))
        )
        second = manager.ApplyTransient(declare().AllowBetween(*more))
        taken['RemoveDeclaration'], _ = timed(lambda: manager.RemoveDeclaration(first))
        manager.RemoveDeclaration(second)
        return taken

    def declared(self, pair: list[int]) -> Any:
        """Exclude a pair of geometries, given by number, for a while; return the filter's id."""
        a, b = self.sets([[k] for k in pair])
        declaration = self._geometry.CollisionFilterDeclaration().ExcludeBetween(a, b)
        return self._manager.ApplyTransient(declaration)

    def remove(self, filter_ids: list[Any]) -> None:
        """Remove transient declarations one by one."""
        for filter_id in filter_ids:
            self._manager.RemoveDeclaration(filter_id)


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    """Return how long a call took [s], and its result."""
    start = time.perf_counter()
    result = call()
    return time.perf_counter() - start, result


def declarations(count: int, packages: list[str]) -> None:
    """Print what declarations cost in a scene of ``count`` geometries."""
    sides = [Side(package, count) for package in packages]
    rng = np.random.default_rng(count)
    for size in (1, count // 10):
        taken: list[list[dict[str, float]]] = [[] for _ in sides]
        for _ in range(REPETITIONS.get(count, 3)):
            rows = rng.permutation(count)[: 4 * size].reshape(4, size).tolist()
            for side, results in zip(sides, taken, strict=True):
                results.append(side.seconds(rows))
        for name in taken[0][0]:
            medians = [median(result[name] for result in side) * 1e6 for side in taken]
            text = ''.join(f'{value:14.1f}' for value in medians)
            ratio = f'{medians[0] / medians[1]:10.4f}' if len(medians) > 1 else ''
            print(f'{count:10d}{size:8d}  {name:18}{text}{ratio}')


def removals(history: int, packages: list[str]) -> None:
    """Print what a removal costs under a history of declarations about a pair of geometries each.

    ``first`` is the removal of the oldest one; ``each`` of one after the other, per removal.
    """
    count = min(history, 200)
    taken = []
    for package in packages:
        side = Side(package, count)
        rng = np.random.default_rng(history)
        pairs = [rng.permutation(count)[:2].tolist() for _ in range(history)]
        ids = [side.declared(pair) for pair in pairs]
        first, _ = timed(lambda side=side, ids=ids: side.remove(ids[:1]))
        rest, _ = timed(lambda side=side, ids=ids: side.remove(ids[1 : 1 + REMOVED]))
        taken.append((first, rest / min(REMOVED, history - 1)))
    for k, name in enumerate(('first', 'each')):
        values = [each[k] * 1e6 for each in taken]
        text = ''.join(f'{value:14.1f}' for value in values)
        ratio = f'{values[0] / values[1]:10.4f}' if len(values) > 1 else ''
        print(f'{history:10d}{"":8}  {"removal, " + name:18}{text}{ratio}')


def masking(count: int) -> None:
    """Print what masking costs beside a gather of as many values from ``count``."""
    state = filled(count)
    rng = np.random.default_rng(1)
    i, j = rng.integers(0, count, size=(2, PAIRS))
    keys = np.arange(1, count + 1)
    slots_a, slots_b = state.slots(keys[i]), state.slots(keys[j])
    values = rng.random(count)
    state.mask(slots_a, slots_b)
    masked, gathered = [], []
    for _ in range(101):
        masked.append(timed(lambda: state.mask(slots_a, slots_b))[0])
        gathered.append(timed(lambda: values[i])[0])
    mask, gather = median(masked) * 1e6, median(gathered) * 1e6
    print(f'{count:10d}{mask:14.1f}{gather:14.1f}{mask / gather:10.2f}')


def filled(count: int) -> FilterState:
    """Return filters of ``count`` geometries with a group, cliques and declarations."""
    state = FilterState()
    keys = tuple(range(1, count + 1))
    for key in keys:
        state.add(key, key, False)
    half = count // 2
    state.add_group('half', keys[:half], ('half',))
    for pair in itertools.pairwise(keys):
        state.add_clique(f'{pair}', pair)
    state.apply(
        [
            (FilterOperation.EXCLUDE_WITHIN, keys[half:], ()),
            (FilterOperation.EXCLUDE_BETWEEN, keys[:9], keys[half:]),
        ]
    )
    return state


def memory(count: int) -> None:
    """Print the memory of the filters of ``count`` geometries."""
    tracemalloc.start()
    state = filled(count)
    used, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    print(f'{count:10d}{used / 1e6:14.2f}    filtered pairs: {state.filtered_pairs()}')


def main() -> None:
    counts = [int(text) for text in sys.argv[1:]] or list(COUNTS)
    packages = ['drake_geom_ros']
    try:
        importlib.import_module('pydrake.geometry')
        packages.append('pydrake')
    except ImportError:
        print('pydrake is not installed here: no comparison')
    header = ''.join(f'{name + " [us]":>14}' for name in ('ours', 'pydrake')[: len(packages)])
    print(f'{"geometries":>10}{"set":>8}  {"operation":18}{header}{"ratio":>10}')
    Side('drake_geom_ros', 4).seconds([[0], [1], [2], [3]])  # compiles
    for count in counts:
        declarations(count, packages)
    print(f'{"history":>10}')
    for history in HISTORIES:
        removals(history, packages)
    print(f'\n{"geometries":>10}{"mask [us]":>14}{"gather [us]":>14}{"ratio":>10}  {PAIRS} pairs')
    for count in counts:
        masking(count)
    print(f'\n{"geometries":>10}{"memory [MB]":>14}')
    for count in counts:
        memory(count)


if __name__ == '__main__':
    main()
