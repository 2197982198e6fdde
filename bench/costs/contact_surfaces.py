"""Time of all contact surfaces, beside pydrake's, in turns in one process.

    ./run exec python bench/costs/contact_surfaces.py

A rigid can between two pads, and 20 soft bodies in a heap, some deep within each other: the same
shapes, poses and resolution hints. Before each question all bodies move a little, up to 10 mm in
the heap, and 10 ms go by, as in a robot, or none. Polygons; milliseconds, without the setting of
poses.
"""

import importlib
import logging
import time

import numpy as np

from truth.bodies.random_bodies import random_rotation

ROUNDS = 100
PAUSES = 0.0, 0.01  # [s]
RIGID = 0.0
CAN = [
    ('Cylinder', (0.033, 0.12), 0.002, RIGID),
    ('Box', (0.01, 0.02, 0.04), 0.005, 1e6),
    ('Box', (0.01, 0.02, 0.04), 0.005, 1e6),
]
KINDS = (
    ('Sphere', (0.05,)),
    ('Box', (0.08, 0.1, 0.06)),
    ('Cylinder', (0.04, 0.1)),
    ('Capsule', (0.03, 0.08)),
    ('Ellipsoid', (0.04, 0.06, 0.05)),
)
HEAP = [(*KINDS[k % 5], 0.02, 1e6) for k in range(20)]


def can_poses(random):
    """Return poses of the can and two pads that are pressed into it by up to 3 mm."""
    x = 0.033 + 0.005 - random.uniform(0.001, 0.003)
    offsets = ([0.0, 0.0, 0.0], [x, 0.0, 0.01], [-x, 0.0, 0.01])
    return [(np.eye(3), np.array(offset)) for offset in offsets]


def heap_poses(random):
    """Return poses of the heap, each moved a little from the same places."""
    first = np.random.default_rng(5)
    for _ in HEAP:
        R, p = random_rotation(first), first.uniform(-0.1, 0.1, 3)
        yield R, p + random.uniform(-0.01, 0.01, 3) / np.sqrt(3.0)


class Side:
    """The scene in one of the packages."""

    def __init__(self, package, bodies):
        geometry = importlib.import_module(f'{package}.geometry')
        self.math = importlib.import_module(f'{package}.math')
        self.polygons = geometry.HydroelasticContactRepresentation.kPolygon
        self.vector = geometry.FramePoseVector
        self.scene = geometry.SceneGraph()
        source = self.scene.RegisterSource('source')
        self.frames = []
        for k, (kind, sizes, hint, modulus) in enumerate(bodies):
            frame = self.scene.RegisterFrame(source, geometry.GeometryFrame(f'frame{k}'))
            properties = geometry.ProximityProperties()
            if modulus == RIGID:
                geometry.AddRigidHydroelasticProperties(hint, properties)
            else:
                geometry.AddCompliantHydroelasticProperties(hint, modulus, properties)
            shape = getattr(geometry, kind)(*sizes)
            instance = geometry.GeometryInstance(self.math.RigidTransform(), shape, 'body')
            instance.set_proximity_properties(properties)
            self.scene.RegisterGeometry(source, frame, instance)
            self.frames.append(frame)
        self.context = self.scene.CreateDefaultContext()
        self.port = self.scene.get_source_pose_port(source)
        self.query = self.scene.get_query_output_port().Eval(self.context)

    def asked(self, poses, pause):
        """Return the milliseconds of one answer after a pause, its surfaces and its polygons."""
        vector = self.vector()
        for frame, (R, p) in zip(self.frames, poses, strict=True):
            pose = self.math.RigidTransform(self.math.RotationMatrix(R), p)
            vector.set_value(frame, pose)
        self.port.FixValue(self.context, vector)
        if pause:
            time.sleep(pause)
        start = time.perf_counter()
        surfaces, _points = self.query.ComputeContactSurfacesWithFallback(self.polygons)
        took = 1e3 * (time.perf_counter() - start)
        return took, len(surfaces), sum(surface.num_faces() for surface in surfaces)


def compare(name, bodies, posed, pause):
    """Ask both packages in turns, and tell."""
    sides = {package: Side(package, bodies) for package in ('drake_geom_ros', 'pydrake')}
    random, times = np.random.default_rng(42), {package: [] for package in sides}
    for number in range(ROUNDS + 1):
        poses = list(posed(random))
        for package, side in sides.items():
            took, *counts = side.asked(poses, pause)
            if number:  # the first may compile
                times[package].append(took)
            if number == ROUNDS:
                all_of = np.array(times[package])
                at = np.median(all_of), all_of.mean(), np.percentile(all_of, 99)
                print(f'{name}, {package}: {counts}; ' + ', '.join(f'{t:.2f}' for t in at))
    ours, theirs = (np.array(times[package]) for package in sides)
    medians, means = np.median(theirs) / np.median(ours), theirs.mean() / ours.mean()
    print(f'{name}: pydrake takes {medians:.2f} times as long (medians), {means:.2f} (means)')


def main():
    logging.getLogger('drake').setLevel(logging.ERROR)
    print('scene, package: surfaces, polygons; median, mean, p99 [ms]')
    for name, bodies, posed in (('can', CAN, can_poses), ('heap', HEAP, heap_poses)):
        for pause in PAUSES:
            compare(f'{name}, after {1e3 * pause:.0f} ms', bodies, posed, pause)


if __name__ == '__main__':
    main()
