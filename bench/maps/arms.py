"""Two arms against a map: our distances within 0.3 m beside octrees of python-fcl and of Coal.

Coal is told the cutoff, by the least distance that a result begins with. python-fcl's ``distance``
makes such a result of its own at each call (its ``fcl.pyx``), so it cannot be told one.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.maps.scenes import Arms, Floats, seen_cells
from bench.motion.clocks import told
from drake_geom_ros.cross_check.fcl_peer import fcl_shape
from drake_geom_ros.geometry import OccupiedCells, Shape

WITHIN = 0.3  # [m]
_WARM = 20  # states


class FclSide:
    """An octree of python-fcl, asked about one link after the other."""

    name = 'python-fcl'

    def __init__(self, cells: OccupiedCells, links: list[Shape]) -> None:
        import fcl  # noqa: TID251  (a measurement of fcl itself)

        self._fcl, self._tree = fcl, fcl.CollisionObject(fcl_shape(cells), fcl.Transform())
        self._links = [fcl.CollisionObject(fcl_shape(link), fcl.Transform()) for link in links]

    def distance(self, k: int, R: Floats, p: Floats) -> float:
        """Return the distance of link k from the map [m]; -1 where they overlap."""
        fcl = self._fcl
        self._links[k].setTransform(fcl.Transform(R, p))
        request, result = fcl.DistanceRequest(), fcl.DistanceResult()
        return float(fcl.distance(self._links[k], self._tree, request, result))


class CoalSide:
    """An octree of Coal, asked likewise."""

    name = 'Coal'

    def __init__(self, cells: OccupiedCells, links: list[Shape]) -> None:
        import coal

        from truth.peers.coal_peer import coal_shape

        self._coal = coal
        self._tree = coal.makeOctree(cells.centres().copy(), cells.resolution())
        self._links = [coal_shape(link) for link in links]
        self._still = coal.Transform3s.Identity()

    def distance(self, k: int, R: Floats, p: Floats) -> float:
        """Return the distance of link k from the map [m], negative where they overlap.

        It is the cutoff where no cell is nearer.
        """
        coal = self._coal
        result = coal.DistanceResult()
        result.min_distance = WITHIN
        X = coal.Transform3s(R, p)
        request = coal.DistanceRequest()
        return float(coal.distance(self._links[k], X, self._tree, self._still, request, result))


def sides(cells: OccupiedCells, links: list[Shape]) -> list[Any]:
    """Return the libraries that are installed here."""
    found: list[Any] = []
    for side in (FclSide, CoalSide):
        try:
            found.append(side(cells, links))
        except ImportError as error:
            print(f'not installed here, left out: {side.name} ({error})')
    return found


def run(states: int, resolution: float) -> None:
    """Print what all sides take, by the processor, state after state in turns."""
    cells = seen_cells(resolution)
    arms = Arms.beside(cells)
    inspector = arms.graph.model_inspector()
    others = sides(cells, [inspector.GetShape(link) for link in arms.links])
    print(f'{cells.count()} cells of {resolution} m, {len(arms.links)} links')
    query = arms.graph.get_query_output_port().Eval(arms.context)
    values = [link.get_value() for link in arms.links]
    ours: list[float] = []
    theirs: dict[str, list[list[float]]] = {side.name: [[], []] for side in others}
    off = dict.fromkeys(theirs, 0.0)
    overlaps = 0
    for number, poses in enumerate(arms.states(states + _WARM, np.random.default_rng(1))):
        arms.pose(poses)
        start = time.process_time()
        found = query.ComputeSignedDistancePairwiseClosestPoints(WITHIN)
        distances = dict(
            zip(np.minimum(found.id_A, found.id_B).tolist(), found.distance, strict=True)
        )
        taken = time.process_time() - start
        if number < _WARM:
            continue
        ours.append(taken)
        overlaps += sum(d < 0.0 for d in distances.values())
        R_WGs, p_WGs = (np.array(x) for x in query.X_WGs(values))
        for side in others:
            for turn, chosen in enumerate((range(len(values)), _near(values, distances))):
                asked, seconds = _each(side.distance, chosen, R_WGs, p_WGs)
                theirs[side.name][turn].append(seconds)
                for k, distance in asked.items():
                    mine = min(distances.get(values[k], np.inf), WITHIN)
                    if min(mine, distance) > 0.0:
                        off[side.name] = max(off[side.name], abs(mine - min(distance, WITHIN)))
    _tell(np.array(ours), theirs, off, overlaps)


def _near(values: list[int], distances: dict[int, float]) -> list[int]:
    return [k for k, value in enumerate(values) if value in distances]


def _each(
    distance: Callable[[int, Floats, Floats], float], chosen: Any, Rs: Floats, ps: Floats
) -> tuple[dict[int, float], float]:
    start = time.process_time()
    asked = {k: distance(k, Rs[k], ps[k]) for k in chosen}
    return asked, time.process_time() - start


def _tell(
    ours: Floats, theirs: dict[str, list[list[float]]], off: dict[str, float], overlaps: int
) -> None:
    print(f'a state, all pairs within {WITHIN} m; {overlaps} overlaps among them')
    told('ours', ours)
    for name, (every, near) in theirs.items():
        told(f'{name}, each link', np.array(every))
        told(f'{name}, only links that are near', np.array(near))
        print(
            f'  {name}: {np.mean(every) / ours.mean():.1f} times ours, '
            f'{np.mean(near) / ours.mean():.1f} times for the near ones alone; distances differ '
            f'by {off[name]:.2g} m at most'
        )
