"""Memory of large shapes: solids by triangle, sensed maps by cell, convex hulls of many points.

    ./run exec python -m bench.costs.memory [--triangles 327680] [--cells 8000000] [--points 1e6]

A solid is a bumpy ball, a map random cells of a grid, a third full. Each is made, registered
beside a ball, and asked for its distances. Numbers are bytes a triangle or cell of what NumPy and
Python hold (tracemalloc), without what the caller holds: at the peak, and in the end. Hulls are
of points in a cube, of which few are vertices, and on a ball, of which all are; their numbers are
megabytes of the process beyond the points (Linux counts them), for most are Qhull's.
"""

from __future__ import annotations

import argparse
import gc
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from drake_geom_ros.geometry import (
    Convex,
    GeometryInstance,
    Mesh,
    MeshData,
    OccupiedCells,
    ProximityProperties,
    QueryObject,
    SceneGraph,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

CELL = 0.05  # [m]


def bumpy_ball(triangles: int) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return vertices and triangles of a ball with waves, of at least so many triangles."""
    level = 0
    while 20 * 4**level < triangles:
        level += 1
    ball: Any = trimesh.creation.icosphere(subdivisions=level)
    vertices = np.array(ball.vertices) * [1.0, 0.8, 0.6]
    return vertices * (1.0 + 0.2 * np.sin(5.0 * ball.vertices[:, :1])), np.array(ball.faces)


def cells(count: int) -> np.ndarray[Any, Any]:
    """Return the centres (count, 3) [m] of random cells."""
    side = int(np.ceil((3 * count) ** (1 / 3)))
    full = np.flatnonzero(np.random.default_rng(0).random(side**3) < 0.4)[:count]
    return CELL * (np.stack(np.unravel_index(full, (side,) * 3), axis=1) + 0.5)


def asked(shape: Shape, properties: ProximityProperties) -> QueryObject:
    """Return a query object of a shape beside a ball that has answered once."""
    graph = SceneGraph()
    source = graph.RegisterSource('bench')
    for name, each, held in (('large', shape, properties), ('ball', Sphere(0.1), None)):
        pose = RigidTransform() if each is shape else RigidTransform([-1.5, 0.0, 0.0])
        instance = GeometryInstance(pose, each, name)
        instance.set_proximity_properties(held or ProximityProperties())
        graph.RegisterAnchoredGeometry(source, instance)
    query = graph.get_query_output_port().Eval(graph.CreateDefaultContext())
    query.ComputeSignedDistanceToPoint([-1.5, 0.0, 0.0])
    query.ComputeSignedDistancePairwiseClosestPoints()
    return query


def line(
    name: str, count: int, make: Callable[[], Shape], properties: ProximityProperties
) -> None:
    """Print the memory of a shape."""
    gc.collect()
    tracemalloc.start()
    shape = make()
    kept = asked(shape, properties)
    peak = tracemalloc.get_traced_memory()[1]
    gc.collect()
    left = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    del kept
    print(
        f'{name:10} {count:10d}: {left / count:6.0f} B each in the end, '
        f'{peak / count:6.0f} B at the peak'
    )


def resident(what: str) -> int:
    """Return the memory of the process [B]: ``VmRSS`` of now, ``VmHWM`` at the peak."""
    lines = Path('/proc/self/status').read_text().splitlines()
    return 1024 * int(next(line for line in lines if line.startswith(what)).split()[1])


def hull_line(name: str, points: np.ndarray[Any, Any]) -> None:
    """Print the memory that the convex hull of points takes beyond them."""
    mesh = Convex.FromMeshData(MeshData(points))
    gc.collect()
    before = resident('VmRSS')
    Path('/proc/self/clear_refs').write_text('5')  # the peak begins anew
    corners, _ = mesh.hull_surface()
    peak = (resident('VmHWM') - before) / 1e6
    print(f'hull {name} {len(points):10d}: {peak:.0f} MB at the peak, {len(corners)} vertices')


def main() -> None:
    """Print a line for a solid, one for a map, and two for hulls."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--triangles', type=int, default=327_680)
    parser.add_argument('--cells', type=int, default=8_000_000)
    parser.add_argument('--points', type=float, default=1e6)
    options = parser.parse_args()
    solid = ProximityProperties()
    solid.AddProperty('mesh', 'solid', True)
    small = bumpy_ball(1000)
    asked(Mesh.FromMeshData(MeshData(*small)), solid)  # compiles what is needed
    vertices, triangles = bumpy_ball(options.triangles)
    line(
        'triangles',
        len(triangles),
        lambda: Mesh.FromMeshData(MeshData(vertices, triangles)),
        solid,
    )
    centres = cells(options.cells)
    line('cells', len(centres), lambda: OccupiedCells(CELL, centres), ProximityProperties())
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (int(options.points), 3))
    hull_line('in a cube', points)
    hull_line('on a ball', points / np.linalg.norm(points, axis=1)[:, None])


if __name__ == '__main__':
    main()
