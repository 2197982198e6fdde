"""Rules about sensed maps and bodies that no sensor of these maps can see.

A map shows nothing near such a body, so the distance is unknown and the rule counts it as near. A
rule about several maps needs one of them to see the body; a rule about one map needs that one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.math.array_types import Flags
from drake_geom_ros.proximity_rules.measured import Measured, UnseenBodies
from drake_geom_ros.proximity_rules.nearest_pairs import NearestPairs
from drake_geom_ros.proximity_rules.watched_pairs import WatchedPairs


def unseen_of_groups(watched: WatchedPairs, bodies: UnseenBodies) -> dict[int, Flags]:
    """Return by group the geometries (n,) that none of its maps sees, of groups with any."""
    some = np.flatnonzero(bodies.is_unseen.any(axis=0))
    if not len(some):
        return {}
    is_unseen, is_reported = bodies.is_unseen[:, some], bodies.is_reported[:, some]
    unseen = {}
    for group in watched.groups_with(bodies.maps).tolist():
        pairs = watched.watches(group, bodies.maps, some) & is_reported
        flags = pairs.any(axis=0) & ~(pairs & ~is_unseen).any(axis=0)
        if flags.any():
            unseen[group] = np.zeros(bodies.is_unseen.shape[1], dtype=np.bool_)
            unseen[group][some[flags]] = True
    return unseen


def unseen_of_rule(
    watched: WatchedPairs, bodies: UnseenBodies, rule: int
) -> list[tuple[int, int]]:
    """Return the bodies that none of a rule's maps sees, each with one of these, by their ids."""
    group = int(watched.groups[rule])
    flags = unseen_of_groups(watched, bodies).get(group, np.zeros(0, dtype=np.bool_))
    return [
        (int(watched.ids[body]), int(watched.ids[_map_about(watched, bodies, group, body)]))
        for body in np.flatnonzero(flags).tolist()
    ]


def _map_about(watched: WatchedPairs, bodies: UnseenBodies, group: int, body: int) -> int:
    """Return the row of a map that a group watches with a body."""
    watches = watched.watches(group, bodies.maps, np.array([body]))[:, 0]
    return int(bodies.maps[np.flatnonzero(watches & bodies.is_reported[:, body])[0]])


def with_unseen_bodies(
    watched: WatchedPairs, measured: Measured, nearest: NearestPairs
) -> tuple[Measured, NearestPairs]:
    """Return a measurement with a pair of unknown distance for each group with an unseen body.

    That pair is the nearest of the group.
    """
    bodies = measured.unseen
    unseen = {} if bodies is None else unseen_of_groups(watched, bodies)
    if bodies is None or not unseen:
        return measured, nearest
    ids = []
    for number, (group, flags) in enumerate(unseen.items()):
        body = int(np.flatnonzero(flags)[0])
        its_map = _map_about(watched, bodies, group, body)
        ids.append(sorted((int(watched.ids[body]), int(watched.ids[its_map]))))
        nearest.lowest[group] = -np.inf
        nearest.lowest_pair[group] = len(measured.id_A) + number
    return _with_unknown(measured, np.array(ids, dtype=np.int64)), nearest


def _with_unknown(measured: Measured, ids: NDArray[np.int64]) -> Measured:
    """Return a measurement with pairs (k, 2) of unknown distance behind the others."""
    count = len(ids)
    unknown, nowhere = np.full(count, np.nan), np.full((count, 3), np.nan)
    speeds = measured.closing_speed
    return measured._replace(
        id_A=np.concatenate([measured.id_A, ids[:, 0]]),
        id_B=np.concatenate([measured.id_B, ids[:, 1]]),
        distance=np.concatenate([measured.distance, unknown]),
        error_bound=np.concatenate([measured.error_bound, np.zeros(count)]),
        p_WCa=np.concatenate([measured.p_WCa, nowhere]),
        p_WCb=np.concatenate([measured.p_WCb, nowhere]),
        closing_speed=None if speeds is None else np.concatenate([speeds, unknown]),
    )
