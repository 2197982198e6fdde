"""Plan a path around obstacles with SciPy and exact derivatives of the distances.

A bar, which may move and turn in the plane, is to come from one side of two posts to the other.
Every way point is a frame of one scene, so one query answers for the whole path, and one call
gives the Jacobian of all distances. The path is as short as it can be at a clearance of 5 cm.

    python examples/around_obstacles.py [PICTURE.png]
"""

import sys

import numpy as np
from scipy.optimize import minimize

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    CollisionFilterDeclaration,
    Cylinder,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw

WAYPOINTS = 15
CLEARANCE = 0.05  # [m]
REACH = 0.3  # [m] beyond which an obstacle is no constraint
LENGTH, RADIUS = 0.5, 0.04  # [m] of the bar
TURN = 0.1  # [m] what a radian of turn counts as
START, END = np.array([-1.0, 0.0, 0.0]), np.array([1.0, 0.1, 0.0])  # x, y [m], angle [rad]
POSTS = {
    'column': (Cylinder(0.2, 1.0), RigidTransform([-0.25, 0.12, 0])),
    'crate': (Box(0.3, 0.4, 1.0), RigidTransform(RollPitchYaw(0, 0, 0.5), [0.45, -0.3, 0])),
}


class Path:
    """The bar at every way point, among the posts."""

    def __init__(self):
        self.graph = graph = SceneGraph()
        source = graph.RegisterSource('plan')
        names = [f'point {k}' for k in range(WAYPOINTS)]
        self.frames = [graph.RegisterFrame(source, GeometryFrame(name)) for name in names]
        lying = RigidTransform(RollPitchYaw(0, np.pi / 2, 0), [0, 0, 0])
        for frame in self.frames:
            self.add(source, frame, Capsule(RADIUS, LENGTH), lying, 'bar')
        for name, (shape, X_WG) in POSTS.items():
            self.add(source, graph.world_frame_id(), shape, X_WG, name)
        # Of the bar at different times no two count.
        graph.collision_filter_manager().Apply(
            CollisionFilterDeclaration().ExcludeWithin(GeometrySet(self.frames))
        )
        self.context = graph.CreateDefaultContext()
        self.query = graph.get_query_output_port().Eval(self.context)

    def add(self, source, frame, shape, X_FG, name):
        """Register a shape that takes part in queries."""
        instance = GeometryInstance(X_FG, shape, name)
        instance.set_proximity_properties(ProximityProperties())
        self.graph.RegisterGeometry(source, frame, instance)

    def ask(self, q):
        """Return the distances of all way points (n, 3) from all posts."""
        poses = np.zeros((WAYPOINTS, 7))
        poses[:, :2] = q[:, :2]
        poses[:, 5], poses[:, 6] = np.sin(q[:, 2] / 2), np.cos(q[:, 2] / 2)
        self.context.UpdateFramePoses(FramePoseVector.FromArrays(self.frames, poses))
        return self.query.ComputeSignedDistancePairwiseClosestPoints()

    def jacobian(self, distances):
        """Return the derivatives of the distances by all of q: each moves one frame."""
        J_WFs = {}
        for k, frame in enumerate(self.frames):
            J_WFs[frame] = np.zeros((6, WAYPOINTS * 3))
            J_WFs[frame][[3, 4, 2], [3 * k, 3 * k + 1, 3 * k + 2]] = 1.0  # vx, vy, wz
        return distances.jacobian_by_frames(J_WFs)


def length(x):
    """Return the sum of the squares of all steps, and its gradient."""
    q = x.reshape(WAYPOINTS, 3)
    steps = np.diff(q, axis=0) * [1.0, 1.0, TURN]
    gradient = np.zeros_like(q)
    gradient[1:] += 2.0 * steps * [1.0, 1.0, TURN]
    gradient[:-1] -= 2.0 * steps * [1.0, 1.0, TURN]
    return np.sum(steps**2), gradient.ravel()


def plan(path):
    """Return the straight path and the one that SciPy finds, both (n, 3), and its report."""
    straight = np.linspace(START, END, WAYPOINTS)
    fixed = np.zeros((6, WAYPOINTS * 3))
    fixed[:3, :3], fixed[3:, -3:] = np.eye(3), np.eye(3)
    ends = np.concatenate((START, END))

    def clear(x):
        return path.ask(x.reshape(-1, 3)).distance - CLEARANCE

    def slopes(x):
        return path.jacobian(path.ask(x.reshape(-1, 3)))

    found = minimize(
        length,
        straight.ravel(),
        jac=True,
        method='SLSQP',
        options={'maxiter': 200, 'ftol': 1e-9},
        constraints=[
            {'type': 'eq', 'fun': lambda x: fixed @ x - ends, 'jac': lambda x: fixed},
            {'type': 'ineq', 'fun': clear, 'jac': slopes},
        ],
    )
    return straight, found.x.reshape(-1, 3), found


def draw(path, straight, planned, target):
    """Draw both paths from above, with the nearest points of the planned one."""
    import matplotlib

    matplotlib.use('Agg')
    from matplotlib import patches, pyplot, transforms

    figure, axes = pyplot.subplots(figsize=(8.0, 3.6), layout='constrained')
    round_end = np.linspace(-np.pi / 2, np.pi / 2, 20)
    half = np.column_stack((LENGTH / 2 + RADIUS * np.cos(round_end), RADIUS * np.sin(round_end)))
    outline = np.vstack((half, -half))
    for shape, X_WG in POSTS.values():
        x, y, _ = X_WG.translation()
        if isinstance(shape, Cylinder):
            axes.add_patch(patches.Circle((x, y), shape.radius(), color='0.6'))
        else:
            turn = np.arctan2(*X_WG.rotation().matrix()[[1, 0], 0])
            w, d = shape.width(), shape.depth()
            axes.add_patch(patches.Rectangle((-w / 2, -d / 2), w, d, color='0.6')).set_transform(
                transforms.Affine2D().rotate(turn).translate(x, y) + axes.transData
            )
    for q, color, label in (
        (straight, 'tab:orange', 'straight'),
        (planned, 'tab:blue', 'planned'),
    ):
        for k, (x, y, turn) in enumerate(q):
            bar = transforms.Affine2D().rotate(turn).translate(x, y).transform(outline)
            named = label if k == 0 else None
            axes.fill(*bar.T, facecolor='none', edgecolor=color, linewidth=1.2, label=named)
    near = path.ask(planned)
    for p, r, gap in zip(near.p_WCa, near.p_WCb, near.distance, strict=True):
        if gap < CLEARANCE + 1e-3:
            axes.plot([p[0], r[0]], [p[1], r[1]], color='black', linewidth=2)
    axes.set(aspect='equal', xlabel='x [m]', ylabel='y [m]', ylim=(-0.55, 0.35))
    axes.legend(loc='lower left')
    figure.savefig(target, dpi=100, bbox_inches='tight')


def main():
    """Plan, and say what was found."""
    path = Path()
    straight, planned, report = plan(path)
    before, after = path.ask(straight).distance.min(), path.ask(planned).distance.min()
    print(f'straight: {before:.3f} m of the posts at the nearest')
    print(f'planned: {after:.3f} m of the posts at the nearest')
    print(f'found: {report.success}')
    if len(sys.argv) > 1:
        draw(path, straight, planned, sys.argv[1])


if __name__ == '__main__':
    main()
