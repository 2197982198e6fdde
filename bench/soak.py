"""Random and awkward scenes without end: every answer must be finite, and keep its promises.

    python -m bench.soak [--pairs 1e6] [--seed 0]

Each scene has bodies of all shapes at one scale, in random poses, or on a lattice with axes
aligned, where everything touches, is flush, parallel or concentric; it moves a little and is asked
again. Counted are the answers that break a promise: not finite, a normal off unit length, witness
points that do not span the distance, a bound wider than the level promises.
"""

from __future__ import annotations

import argparse
import math
import time
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Shape,
    SignedDistanceResults,
    Sphere,
)
from drake_geom_ros.geometry.mesh_source import MeshData
from drake_geom_ros.math import RigidTransform

Floats = NDArray[np.float64]

BODIES = 40
SCALES = (1e-6, 1e-3, 1.0, 1e4)  # [m]
ROUNDING = 1e-12  # of the size, in the identities
# Of the size: rings of equal minima, on a lattice, leave EPA with about 1e-7, which is wider than
# promised; nothing has been seen to leave more than this.
VERY_WIDE = 1e-5


def random_shape(rng: np.random.Generator, scale: float, lattice: bool) -> Shape:
    """Return a shape about as large as ``scale`` [m]; on a lattice of a few equal sizes."""
    a, b, c = rng.integers(1, 3, 3) / 2.0 if lattice else 10.0 ** rng.uniform(-2, 0, 3)
    a, b, c = scale * a, scale * b, scale * c
    kinds: list[Shape] = [
        Sphere(a),
        Box(2 * a, 2 * b, 2 * c),
        Capsule(a, 2 * b),
        Cylinder(a, 2 * b),
        Ellipsoid(a, b, c),
        Convex.FromMeshData(MeshData(_vertices(rng, lattice) * [a, b, c])),
    ]
    return kinds[int(rng.integers(len(kinds)))]


def _vertices(rng: np.random.Generator, lattice: bool) -> Floats:
    """Return points whose hull is a cube on a lattice, else has a dozen vertices or fewer."""
    if lattice:
        return np.indices((2, 2, 2)).reshape(3, -1).T - 0.5
    return rng.uniform(-1.0, 1.0, (12, 3))


def random_poses(rng: np.random.Generator, scale: float, lattice: bool) -> Floats:
    """Return poses (BODIES, 7): anywhere, or on lattice points in one of few orientations."""
    poses = np.empty((BODIES, 7))
    if lattice:
        poses[:, :3] = scale * rng.integers(-2, 3, (BODIES, 3)) / 2.0
        halves = np.array([[0, 0, 0, 1.0], [1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [1, 1, 1, 1]])
        poses[:, 3:] = halves[rng.integers(len(halves), size=BODIES)]
    else:
        poses[:, :3] = scale * rng.uniform(-1.5, 1.5, (BODIES, 3))
        poses[:, 3:] = rng.normal(size=(BODIES, 4))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    return poses


def broken(results: SignedDistanceResults, scale: float) -> Counter[str]:
    """Count the promises that answers break; sizes are of the order of ``scale`` [m]."""
    apart = results.p_WCa - results.p_WCb
    identity = apart - results.distance[:, None] * results.nhat_BA_W
    numbers = (results.distance, results.nhat_BA_W, results.p_ACa, results.p_BCb)
    finite = np.ones(len(results), dtype=bool)
    for array in numbers:
        finite &= np.isfinite(array.reshape(len(results), -1)).all(axis=1)
    lengths = np.linalg.norm(results.nhat_BA_W, axis=1)
    return Counter(
        {
            'not finite': int(np.count_nonzero(~finite)),
            'normal not unit': int(np.count_nonzero(~(abs(lengths - 1.0) <= ROUNDING))),
            'witness points apart': int(
                np.count_nonzero(~(np.linalg.norm(identity, axis=1) <= 10 * ROUNDING * scale))
            ),
            'wider than promised': int(np.count_nonzero(results.breaks_promise())),
            'very wide bound': int(np.count_nonzero(~(results.error_bound <= VERY_WIDE * scale))),
        }
    )


def soak(pairs: int, seed: int) -> tuple[int, Counter[str]]:
    """Ask for at least so many pairs; return how many were answered, and what was broken."""
    rng = np.random.default_rng(seed)
    answered, counts = 0, Counter[str]()
    while answered < pairs:
        scale, lattice = float(rng.choice(SCALES)), bool(rng.random() < 0.5)
        graph = SceneGraph()
        source = graph.RegisterSource('soak')
        frames = []
        for number in range(BODIES):
            frames.append(graph.RegisterFrame(source, GeometryFrame(f'{number}')))
            _register(graph, source, frames[-1], random_shape(rng, scale, lattice))
        _register(graph, source, graph.world_frame_id(), HalfSpace())
        context = graph.CreateDefaultContext()
        query = graph.get_query_output_port().Eval(context)
        ids = np.array([frame.get_value() for frame in frames])
        for _ in range(4):
            poses = random_poses(rng, scale, lattice)
            for step in (0.0, 1e-15, 1e-9, 1e-3):
                poses[:, :3] += scale * step * rng.normal(size=(BODIES, 3))
                context.UpdateFramePoses(FramePoseVector.FromArrays(ids, poses))
                reach = float(rng.choice([0.0, 0.1 * scale, math.inf]))
                results = query.ComputeSignedDistancePairwiseClosestPoints(reach)
                answered += len(results)
                counts += broken(results, scale)
                if query.HasCollisions() != bool(len(query.ComputePointPairPenetration())):
                    counts['HasCollisions disagrees'] += 1
    return answered, counts


def _register(graph, source, frame, shape: Shape) -> None:  # type: ignore[no-untyped-def]
    instance = GeometryInstance(RigidTransform(), shape, 'shape')
    instance.set_proximity_properties(ProximityProperties())
    graph.RegisterGeometry(source, frame, instance)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--pairs', type=float, default=1e6, help='how many to ask for')
    parser.add_argument('--seed', type=int, default=0)
    arguments = parser.parse_args()
    start = time.perf_counter()
    answered, counts = soak(int(arguments.pairs), arguments.seed)
    print(f'{answered} pairs in {time.perf_counter() - start:.0f} s; broken promises:')
    for name in sorted(counts) or ['none']:
        print(f'  {name}: {counts[name]}')


if __name__ == '__main__':
    main()
