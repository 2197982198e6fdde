"""Collision filters of a compiled model of MuJoCo.

Two geometries make contacts if the ``contype`` of one shares a bit with the ``conaffinity`` of the
other, unless their bodies are welded together, a joint connects these (the world excepted), or an
``<exclude>`` names the bodies. A ``<pair>`` makes contacts whatever else is said. Source: MuJoCo's
documentation, *Collision detection, Selection*.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import combinations_with_replacement
from typing import Any

from drake_geom_ros.geometry import FilterOperation
from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    DeclarationDescription,
    FilterDescription,
    GeometryDescription,
    Member,
    RobotOptions,
    Statement,
)
from drake_geom_ros.scene_files.errors import Location

_BETWEEN, _WITHIN = FilterOperation.EXCLUDE_BETWEEN, FilterOperation.EXCLUDE_WITHIN
_ALLOWED = FilterOperation.ALLOW_BETWEEN
_Groups = Mapping[Any, tuple[Member, ...]]


def filters_of(
    model: Any,
    geometries: Mapping[int, GeometryDescription],
    options: RobotOptions,
    where: Location,
) -> Iterator[FilterDescription]:
    """Yield the filters of a model; ``geometries`` are by their ids in it."""
    members = {id: Member(g.source, g.frame, g.name) for id, g in geometries.items()}
    statements = [*_by_bits(model, members), *_excluded(model, members)]
    if options.filter_adjacent_links:
        by_weld = _grouped(members, lambda id: int(model.body_weldid[model.geom_bodyid[id]]))
        for weld, inside in by_weld.items():
            if len(inside) > 1:
                yield CliqueDescription(f'{inside[0].source}: welded body {weld}', inside, where)
        statements += _between_parents(model, by_weld)
    pairs = [
        Statement(_ALLOWED, (members[a],), (members[b],))
        for a, b in zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)
    ]
    if statements or pairs:
        yield DeclarationDescription((*statements, *pairs), where)


def _by_bits(model: Any, members: Mapping[int, Member]) -> Iterator[Statement]:
    groups = _grouped(
        members, lambda id: (int(model.geom_contype[id]), int(model.geom_conaffinity[id]))
    )
    for a, b in combinations_with_replacement(groups, 2):
        if not (a[0] & b[1] or b[0] & a[1]):
            yield Statement(
                *((_WITHIN, groups[a]) if a == b else (_BETWEEN, groups[a], groups[b]))
            )


def _excluded(model: Any, members: Mapping[int, Member]) -> Iterator[Statement]:
    by_body = _grouped(members, lambda id: int(model.geom_bodyid[id]))
    for signature in model.exclude_signature.tolist():
        bodies = signature >> 16, signature & 0xFFFF
        if all(body in by_body for body in bodies):
            yield Statement(_BETWEEN, *(by_body[body] for body in bodies))


def _between_parents(model: Any, by_weld: _Groups) -> Iterator[Statement]:
    """Yield the pairs of a welded body and the one that a joint holds it to, but the world."""
    import mujoco

    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT:
        return
    for weld, inside in by_weld.items():
        parent = int(model.body_weldid[model.body_parentid[weld]])
        if weld and parent and parent in by_weld:
            yield Statement(_BETWEEN, inside, by_weld[parent])


def _grouped(members: Mapping[int, Member], key: Any) -> _Groups:
    groups: defaultdict[Any, list[Member]] = defaultdict(list)
    for id, member in members.items():
        groups[key(id)].append(member)
    return {key: tuple(inside) for key, inside in groups.items()}
