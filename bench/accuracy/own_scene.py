"""What each accuracy would cost for the pairs of one scene: ``./run accuracy --scene FILE``."""

from __future__ import annotations

import math
from pathlib import Path

from drake_geom_ros.geometry import QueryObject, SceneGraph
from drake_geom_ros.scene_files import load_scene

SAMPLES = 256  # pairs
ROUNDS = 5  # samples, of which each accuracy has its fastest: other load only adds time


def costs_of_scene(file: Path, max_distance: float = math.inf) -> list[str]:
    """Return lines with the time of a pair at each accuracy; raises GeometryError for no scene."""
    graph = SceneGraph()
    load_scene(file, graph)
    query = QueryObject(graph.CreateDefaultContext())
    found = [query.cost_of_levels(max_distance, samples=SAMPLES) for _ in range(ROUNDS)]
    samples = found[0][1]
    if not samples:
        return [f'{file}: no two bodies are within {max_distance:g} m of each other']
    costs = {level: min(costs[level] for costs, _ in found) for level in found[0][0]}
    lines = [f'{file}: {samples} pairs; a gain above 1 is faster than exact']
    lines.append(f'{"accuracy":>10}{"us a pair":>12}{"gain":>8}')
    for level, seconds in costs.items():
        gain = costs['exact'] / seconds
        lines.append(f'{level:>10}{seconds * 1e6:12.2f}{gain:8.2f}')
    return lines
