"""Option ``--between``: only pairs of two sets, such as ``left:right``."""

import argparse
from collections.abc import Sequence

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
)


def add_between_to(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the option; ``what`` says which pairs are meant."""
    parser.add_argument(
        '--between',
        action='append',
        default=[],
        metavar='A:B',
        help='pairs of two names or patterns of sources, frames or geometries that '
        f'{what} about (default: all); may be repeated',
    )


def exclude_other_pairs(
    scene_graph: SceneGraph, context: SceneGraphContext, between: Sequence[str]
) -> str:
    """Exclude all pairs but those of sets such as ``left:right``; return the names of the sets.

    Raises ArgumentError for a set without a pair that is not excluded, or for another text.
    """
    from drake_geom_ros.recordings.pair_sets import pair_sets, reported_pairs  # takes 0.1 s

    query, sets = QueryObject(context), pair_sets(between)
    ids, wanted = reported_pairs(query, sets)
    others = query.inspector().candidate_matrix()[1] & ~wanted
    declaration = CollisionFilterDeclaration()
    for value, left_out in zip(ids.tolist(), others, strict=True):
        partners = [GeometryId(other) for other in ids[left_out].tolist() if other > value]
        if partners:
            declaration.ExcludeBetween(GeometrySet(GeometryId(value)), GeometrySet(partners))
    scene_graph.collision_filter_manager(context).Apply(declaration)
    return ', '.join(pairs.name for pairs in sets)
