"""Bodies that float and move, and what a fine scan by our own distances sees of them."""

import math

import numpy as np
from batch.floating_bodies import Floating

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.math.batched import matrices_from_poses, poses_from_matrices


def pose(x=0.0, y=0.0, z=0.0, axis=(0, 0, 1), angle=0.0):
    """Return x y z qx qy qz qw."""
    half = 0.5 * angle
    unit = np.array(axis, dtype=float) / np.linalg.norm(axis)
    return [x, y, z, *(math.sin(half) * unit), math.cos(half)]


class Moving(Floating):
    """Floating bodies with a query object each for the start of a motion."""

    def query(self, poses):
        context = self.graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector.FromArrays(self.ids, np.array(poses, float)))
        return self.graph.get_query_output_port().Eval(context)

    def check(self, starts, ends, **asked):
        """Return CheckMotion of all bodies from some poses (n, 7) to others."""
        end = FramePoseVector.FromArrays(self.ids, np.array(ends, float))
        return self.query(starts).CheckMotion(end, **asked)

    def scan(self, starts, ends, interpolation, count=200):
        """Return times, and the least distances and their error bounds of so many states."""
        times = np.linspace(0.0, 1.0, count + 1)
        poses = np.stack(
            [interpolated(s, e, times, interpolation) for s, e in zip(starts, ends, strict=True)],
            axis=1,
        )
        least = evaluate(self.graph, self.ids, poses, 'least')
        return times, least.distance, least.error_bound


def interpolated(start, end, times, interpolation):
    """Return poses (N, 7) of a frame; by matrices and exponentials, unlike what is tested."""
    from scipy.linalg import expm, logm

    (R0, R1), (p0, p1) = matrices_from_poses(np.array([start, end], float))
    if interpolation == 'screw':
        X0, X1 = np.eye(4), np.eye(4)
        X0[:3, :3], X0[:3, 3], X1[:3, :3], X1[:3, 3] = R0, p0, R1, p1
        twist = np.real(logm(np.linalg.solve(X0, X1)))
        Xs = np.array([X0 @ expm(t * twist) for t in times])
        return poses_from_matrices(Xs[:, :3, :3], Xs[:, :3, 3])
    turn = np.real(logm(R0.T @ R1))
    Rs = np.array([R0 @ expm(t * turn) for t in times])
    return poses_from_matrices(Rs, p0 + times[:, None] * (p1 - p0))
