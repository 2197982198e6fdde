"""Cost of derivatives beside the query that they are of.

    ./run exec python bench/costs/derivatives.py [--bodies 60] [--turns 40]

Bodies of one kind, or of all, move a little between queries for all pairs within 0.5 m. The query
and the gradients with their flags are timed in turns, by the time of the thread; medians.
"""

import argparse
import statistics
import time

import numpy as np

from drake_geom_ros.cross_check.bodies import BOUNDED
from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.math.batched import poses_from_matrices
from truth.bodies.random_bodies import random_body, random_rotations
from truth.judging.asking import BodyScene

KINDS = (*BOUNDED, 'Convex')
REACH = 0.5  # [m]
STEP = 1e-3  # [m] between queries


def measured(kinds, bodies, turns):
    """Return the number of pairs and the times [s] of a query and of its gradients."""
    rng = np.random.default_rng(0)
    scene = BodyScene([random_body(rng, kinds[k % len(kinds)], 24) for k in range(bodies)])
    context = scene.graph.CreateDefaultContext()
    query = scene.asked(context)
    Rs, ps = random_rotations(rng, bodies), rng.uniform(-0.6, 0.6, (bodies, 3))
    times, pairs = [], 0
    for _ in range(turns):
        ps += STEP * rng.normal(size=ps.shape)
        poses = poses_from_matrices(Rs, ps)
        context.UpdateFramePoses(FramePoseVector.FromArrays(scene.frames, poses))
        moments = [time.thread_time()]
        found = query.ComputeSignedDistancePairwiseClosestPoints(REACH)
        moments.append(time.thread_time())
        _ = found.gradients, found.is_gradient_unique
        moments.append(time.thread_time())
        times.append(np.diff(moments))
        pairs = len(found)
    # The first turns compile, or load what was compiled.
    return pairs, *map(statistics.median, zip(*times[turns // 4 :], strict=True))


def main():
    """Print a line for each kind of bodies, and one for all of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--bodies', type=int, default=60)
    parser.add_argument('--turns', type=int, default=40)
    options = parser.parse_args()
    print(f'{"bodies":10} {"pairs":>6} {"query [us]":>11} {"gradients [us]":>15} {"ratio":>6}')
    for name, kinds in {**{kind: (kind,) for kind in KINDS}, 'all': KINDS}.items():
        pairs, query, gradients = measured(kinds, options.bodies, options.turns)
        ratio = gradients / query
        print(f'{name:10} {pairs:6} {1e6 * query:11.0f} {1e6 * gradients:15.0f} {ratio:6.2f}')


if __name__ == '__main__':
    main()
