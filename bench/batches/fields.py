"""Fields of signed distances of the two arms' scene, beside pydrake's loop over points.

    ./run exec python -m bench.batches.fields [--resolution 0.02]

Microseconds a point of one thread by processor time, and of all cores by the clock, in one run.
pydrake is asked about 2000 of the points.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from bench.batches.ours import Ours
from bench.batches.timing import seconds, sides
from drake_geom_ros.batch import sample_sdf
from drake_geom_ros.geometry import FramePoseVector

BOUNDS = [[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]]  # [m]
FEW = 2000


def main() -> None:
    """Print the times, and how far both are apart."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--resolution', type=float, default=0.02)
    options = parser.parse_args()
    ours = Ours()
    others = {other.name: other for other in sides(ours)}
    context, (state,) = ours.scene_graph.CreateDefaultContext(), ours.states(1)
    (poses,) = ours.joints.poses(state[None])
    context.UpdateFramePoses(FramePoseVector.FromArrays(ours.joints.frame_ids, poses))
    field = sample_sdf(context, BOUNDS, options.resolution)
    count = field.distance.size
    one, every = (
        seconds(lambda n=n: sample_sdf(context, BOUNDS, options.resolution, threads=n), clock)
        for n, clock in ((1, time.process_time), (0, time.perf_counter))
    )
    print(
        f'{count} points: {1e6 * one / count:.2f} us a point, all cores {1e6 * every / count:.2f}'
    )
    if 'pydrake' in others:
        some = np.random.default_rng(0).integers(0, count, FEW)
        points = field.points.reshape(-1, 3)[some]
        drake = others['pydrake']
        theirs = seconds(lambda: drake.distances_to_points(state, points), time.process_time)
        off = np.abs(drake.distances_to_points(state, points) - field.distance.ravel()[some])
        ratio = theirs / FEW / (one / count)
        print(f'pydrake: {1e6 * theirs / FEW:.2f} us a point, {ratio:.1f} times ours')
        print(f'distances differ by {off.max():.2g} m at most')


if __name__ == '__main__':
    main()
