"""Half spaces that overlap, which no list of pairs contains."""

from __future__ import annotations

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.geometry import GeometryId, QueryObject
from drake_geom_ros.live.conversions.names import NameTable, some_of


def overlapping_half_spaces(query: QueryObject, names: NameTable) -> str:
    """Return a sentence about the unfiltered half spaces that overlap; empty where none do.

    They have no distance, and no depth, so that a list without them may look free.
    """
    pairs = [
        ' and '.join(names.geometry_names[GeometryId(value)] for value in ids)
        for ids in query.half_space_gaps().overlapping.tolist()
    ]
    if not pairs:
        return ''
    return (
        f'{counted(len(pairs), "pair")} of half spaces that overlap {are(len(pairs))} in no list '
        f'of distances or penetrations: {some_of(pairs)}; filter what does not count'
    )
