"""Signed distances of points to a solid, beside libigl and trimesh: microseconds a point.

    ./run exec python -m bench.costs.points [--points 20000] [--rounds 5] [--opinions FOLDER]

A torus of 0.5 and 0.2 m in some numbers of triangles, points at random in the cube around it, as
they come and in the order of a curve. All in turns in one run; the least over rounds of the
processor's time, so that more threads gain nothing, and beside it the clock's. libigl is asked for
pseudonormals, the fastest of its signs; it is not among the requirements: ``pip install --target
FOLDER --no-deps libigl`` brings it.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import trimesh

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    Mesh,
    MeshData,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats

SECTIONS = ((32, 16), (64, 32), (256, 128))
BITS = 10  # a coordinate's, in the order of the curve
FEW = 200  # points that trimesh is asked about

Ask = Callable[[Floats], Floats]


def ours(vertices: Floats, triangles: Any) -> Ask:
    """Return what asks this package."""
    graph = SceneGraph()
    source = graph.RegisterSource('bench')
    frame = graph.RegisterFrame(source, GeometryFrame('frame'))
    mesh = Mesh.FromMeshData(MeshData(vertices, triangles))
    body = GeometryInstance(RigidTransform(), mesh, 'torus')
    body.set_proximity_properties(ProximityProperties())
    graph.RegisterGeometry(source, frame, body)
    context = graph.CreateDefaultContext()
    context.UpdateFramePoses(FramePoseVector({frame: RigidTransform()}))
    query = graph.get_query_output_port().Eval(context)
    return lambda points: query.ComputeSignedDistanceToPoint(points).distance


def of_libigl(igl: Any, vertices: Floats, triangles: Any) -> Ask:
    """Return what asks libigl, by pseudonormals."""
    faces, sign = triangles.astype(np.int64), igl.SIGNED_DISTANCE_TYPE_PSEUDONORMAL
    return lambda points: igl.signed_distance(points, vertices, faces, sign)[0]


def along_a_curve(points: Floats) -> Floats:
    """Return points in the order of a curve that fills space: the bits of coordinates in turn."""
    low, high = points.min(axis=0), points.max(axis=0)
    cells = ((points - low) / (high - low) * (2**BITS - 1)).astype(np.int64)
    codes = np.zeros(len(points), dtype=np.int64)
    for bit in range(BITS):
        for axis in range(3):
            codes |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return points[np.argsort(codes, kind='stable')]


def measure(asks: dict[str, Ask], points: Floats, rounds: int) -> dict[str, tuple[float, float]]:
    """Return the processor's and the clock's microseconds a point of each, in turns."""
    found = dict.fromkeys(asks, (np.inf, np.inf))
    for turn in range(rounds + 1):
        for name, ask in asks.items():
            some = points[:FEW] if name == 'trimesh' else points
            spent, begun = time.process_time(), time.perf_counter()
            ask(some)
            took = time.process_time() - spent, time.perf_counter() - begun
            if turn:  # the first warms up
                cpu, clock = found[name]
                found[name] = min(cpu, took[0]), min(clock, took[1])
    sizes = {name: FEW if name == 'trimesh' else len(points) for name in asks}
    return {
        name: (1e6 * cpu / sizes[name], 1e6 * clock / sizes[name])
        for name, (cpu, clock) in found.items()
    }


def main() -> None:
    """Measure, check that all agree, and print a line for each mesh and order of points."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--points', type=int, default=20_000)
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--opinions', help='a folder in which libigl is installed')
    given = parser.parse_args()
    if given.opinions:
        sys.path.append(given.opinions)
    points = np.random.default_rng(0).uniform(-0.8, 0.8, (given.points, 3))
    for major, minor in SECTIONS:
        torus = trimesh.creation.torus(0.5, 0.2, major_sections=major, minor_sections=minor)
        vertices, triangles = np.array(torus.vertices), np.array(torus.faces)
        asks: dict[str, Ask] = {'ours': ours(vertices, triangles)}
        if given.opinions:
            asks['libigl'] = of_libigl(importlib.import_module('igl'), vertices, triangles)
        nearest = trimesh.proximity.ProximityQuery(torus)
        asks['trimesh'] = lambda some, nearest=nearest: -nearest.signed_distance(some)  # type: ignore[misc]
        for order, some in (('as they come', points), ('along a curve', along_a_curve(points))):
            truth = asks['ours'](some[:FEW])
            for name, ask in asks.items():
                np.testing.assert_allclose(
                    ask(some[:FEW]), truth, rtol=0, atol=1e-12, err_msg=name
                )
            told = measure(asks, some, given.rounds)
            line = ', '.join(
                f'{name} {cpu:.2f} ({clock:.2f})' for name, (cpu, clock) in told.items()
            )
            print(f'{len(triangles)} triangles, points {order}: {line}', flush=True)


if __name__ == '__main__':
    main()
