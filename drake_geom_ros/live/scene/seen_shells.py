"""Points that sensors saw beside bodies, which are in no map: for rules and for answers.

A rule takes them for near by the distance of their cells, of the poses of each cycle; answers say
how many there are, for no distance is computed with them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.geometry import GeometryId, QueryObject
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.proximity_rules import Measured, ScenePairs


class SeenShell(NamedTuple):
    """Points beside bodies of the last message, and those of earlier ones that are held."""

    centres: Floats  # (n, 3) [m] of cells, in the world
    reach: float  # [m] how far a point of a cell is from its centre at most
    points: int  # of the last message
    nearest: float  # [m] least distance of one of these from a body, then; inf: there was none


class BesideBodies(NamedTuple):
    """The number of points beside bodies, and the minimum distance [m] of one from a body."""

    points: int
    nearest: float
    cells: int  # with these, and with those that are held from before

    def fill(self, *messages: Any) -> None:
        """Fill the fields of answers, and of the report of a cycle."""
        for message in messages:
            message.shell_points, message.least_shell_distance = self.points, self.nearest

    def in_words(self) -> str:
        """Return a sentence about it; empty where there are none."""
        if not self.cells:
            return ''
        near = f', the nearest {self.nearest:.3g} m from one' if self.points else ''
        points = f'{counted(self.points, "point")} of sensors {are(self.points)}'
        return (
            f'{points} beside bodies{near}, in {counted(self.cells, "cell")} that sensors did not '
            'look past since: no distance is computed with them (see obstacle_noise)'
        )


NO_SHELL = SeenShell(np.zeros((0, 3)), 0.0, 0, math.inf)
NOTHING_BESIDE = BesideBodies(0, math.inf, 0)


def joined(shells: Sequence[SeenShell]) -> SeenShell:
    """Return what several sensors of a map saw beside bodies."""
    return SeenShell(
        np.concatenate([shell.centres for shell in shells]),
        max(shell.reach for shell in shells),
        sum(shell.points for shell in shells),
        min(shell.nearest for shell in shells),
    )


def beside_bodies(shells: Iterable[SeenShell]) -> BesideBodies:
    """Return what several shells hold together."""
    points, nearest, cells = NOTHING_BESIDE
    for shell in shells:
        points, cells = points + shell.points, cells + len(shell.centres)
        nearest = min(nearest, shell.nearest)
    return BesideBodies(points, nearest, cells)


def with_shells(
    measured: Measured,
    query: QueryObject,
    shells: Sequence[tuple[GeometryId, SeenShell]],
    pairs: ScenePairs,
    farthest: float,
) -> Measured:
    """Return what was measured, and each body's least distance from the cells beside bodies.

    Such a distance counts as one from the map, within ``farthest`` [m]; of ``pairs`` those that
    are reported.
    """
    rows = [row for each in shells if (row := rows_beside(query, *each, pairs, farthest))]
    if not rows:  # as in most cycles
        return measured
    columns = zip(measured[:6], *rows, strict=True)
    joined = [np.concatenate([np.asarray(part) for part in column]) for column in columns]
    speeds = measured.closing_speed
    if speeds is not None:
        unknown = np.full(len(joined[0]) - len(speeds), np.nan)
        speeds = np.concatenate([speeds, unknown])
    ids, others, distances, bounds, p_WCas, p_WCbs = joined
    beside = distances[len(measured.distance) :]  # of cells that nobody counted: any may be many
    counted = {n: np.concatenate([each, beside]) for n, each in measured.counted.items()}
    return measured._replace(
        id_A=ids,
        id_B=others,
        distance=distances,
        error_bound=bounds,
        p_WCa=p_WCas,
        p_WCb=p_WCbs,
        closing_speed=speeds,
        counted=counted,
    )


def rows_beside(
    query: QueryObject, its_map: GeometryId, shell: SeenShell, pairs: ScenePairs, farthest: float
) -> tuple[NDArray[Any], ...]:
    """Return ids, distances, bounds and nearest points of bodies and a shell, a row a body."""
    own = int(np.searchsorted(pairs.ids, its_map.get_value()))
    if own == len(pairs.ids) or pairs.ids[own] != its_map.get_value():
        return ()
    partners = pairs.ids[pairs.reported.rows(np.array([own]))[0]]
    distances_to_bodies = query.ComputeSignedDistanceToPoint(shell.centres, farthest + shell.reach)
    ids, distances = np.asarray(distances_to_bodies.id_G), np.asarray(distances_to_bodies.distance)
    order = np.lexsort((distances, ids))
    order = order[np.isin(ids[order], partners)]
    _, firsts = np.unique(ids[order], return_index=True)
    rows = order[firsts]
    if not len(rows):
        return ()
    ids, distances = ids[rows], distances[rows]
    p_WQs = shell.centres[distances_to_bodies.point_index[rows].astype(np.int64)]
    p_WNs = p_WQs - distances[:, np.newaxis] * distances_to_bodies.grad_W[rows]
    map_ids = np.full(len(ids), its_map.get_value())
    is_first = (ids < map_ids)[:, np.newaxis]
    return (
        np.minimum(ids, map_ids),
        np.maximum(ids, map_ids),
        distances,
        distances_to_bodies.error_bound[rows] + shell.reach,
        np.where(is_first, p_WNs, p_WQs),
        np.where(is_first, p_WQs, p_WNs),
    )
