"""Matter that sensors saw beside bodies, and space that none sees, for proofs of stops.

Sensed maps lack both, so that a proof against the maps alone would look free there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from drake_geom_ros.geometry import GeometryId, QueryObject
from drake_geom_ros.live.scene.out_of_sight import MapSights
from drake_geom_ros.live.scene.scene_rules import SceneRules
from drake_geom_ros.live.scene.seen_shells import SeenShell, rows_beside
from drake_geom_ros.proximity_rules import ProximityRule, unseen_of_rule
from drake_geom_ros.stopping import FindUnmapped, Unmapped


class Sensed(NamedTuple):
    """By map, what its sensors saw beside bodies, which it lacks, and where they can see."""

    shells: Sequence[tuple[GeometryId, SeenShell]]
    sights: Sequence[MapSights]


def finding_unmapped(
    scene_rules: SceneRules, query: QueryObject, rules: Sequence[ProximityRule], sensed: Sensed
) -> FindUnmapped | None:
    """Return a function that finds what is beside bodies, for each of some ``rules``.

    None: there is nothing. The rules are bound already.
    """
    unseen: list[list[Unmapped]] = [[] for _ in rules]
    if sensed.sights:
        bodies = scene_rules.unseen_bodies(query, sensed.sights)
        for rows, rule in zip(unseen, rules, strict=True):
            number = scene_rules.rules.index(rule)
            rows += [
                Unmapped(*each) for each in unseen_of_rule(scene_rules.watched, bodies, number)
            ]
    if not (sensed.shells or any(unseen)):
        return None

    def find(reach: float) -> list[list[Unmapped]]:
        near = _near(scene_rules, query, sensed.shells, reach)
        return [[*near, *rows] for rows in unseen]

    return find


def _near(
    scene_rules: SceneRules,
    query: QueryObject,
    shells: Sequence[tuple[GeometryId, SeenShell]],
    reach: float,
) -> list[Unmapped]:
    """Return each body's nearest of the cells that sensors saw beside bodies."""
    near = []
    for its_map, shell in shells:
        rows = rows_beside(query, its_map, shell, scene_rules.pairs, reach)
        for id_A, id_B, *row in zip(*rows, strict=True):
            body = id_B if id_A == its_map.get_value() else id_A
            near.append(Unmapped(int(body), its_map.get_value(), *row))
    return near
