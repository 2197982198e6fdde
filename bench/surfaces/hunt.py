"""A search for answers about contact surfaces that break a law, where bodies are flush.

Shapes of sizes that are halves of each other, from a millimetre to a kilometre, are put on a
lattice: faces on faces, corners on planes, one body in another, each perhaps moved or turned by
next to nothing. Nothing may be raised but what is documented, and no number be other than finite;
a surface has area, its faces make up its sums, and pressures are not below zero. Which of two
bodies is M changes nothing but signs. Where an area jumps with bodies moved by next to nothing it
is one of those around it, or between them: see ``nearby``. Jumps are counted.
"""

from __future__ import annotations

import itertools
import time
from collections import Counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros import geometry
from drake_geom_ros.geometry import ContactSurfaceResults, FramePoseVector, GeometryError
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import random_rotation
from truth.surfaces.nearby import ALLOWED, HARDER, is_alone, numbers_of, poses_near

Floats = NDArray[np.float64]
Pose = tuple[Floats, Floats]
Poses = tuple[Pose, Pose]

_SIZES = {'Sphere': 1, 'Box': 3, 'Cylinder': 2, 'Capsule': 2, 'Ellipsoid': 3}
_SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
_POSES = 25  # of each pair of bodies


class Body(NamedTuple):
    """A shape, and how it presses: 0 Pa is rigid."""

    shape: geometry.Shape
    modulus: float
    hint: float


def random_body(random: np.random.Generator, scale: float, soft: bool) -> Body:
    """Return a body of about a scale [m]."""
    kind = str(random.choice([*_SIZES, 'Convex', 'Mesh', 'HalfSpace']))
    modulus = float(random.choice([1e3, 1e5, 1e5, 2e5, 1e7])) if soft else 0.0
    hint = float(scale * random.choice([0.3, 0.5, 1.0, 4.0]))
    corners = scale * np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
    if kind == 'HalfSpace':
        return Body(geometry.HalfSpace(), modulus, hint)
    if kind == 'Mesh':
        faces = [t for a, b, c, d in _SQUARES for t in ((a, b, c), (a, c, d))]
        mesh = geometry.MeshData(corners, faces)
        return Body(geometry.Mesh.FromMeshData(mesh), modulus, hint)
    if kind == 'Convex':
        points = corners if random.random() < 0.5 else scale * random.integers(-2, 3, (10, 3)) / 2
        if np.linalg.matrix_rank(points - points[0]) == 3:
            return Body(geometry.Convex(points=points.T, label='hull'), modulus, hint)
        kind = 'Box'
    sizes = (scale * random.choice([0.5, 1.0, 1.0, 2.0], _SIZES[kind])).tolist()
    return Body(getattr(geometry, kind)(*sizes), modulus, hint)


def random_pose(random: np.random.Generator, scale: float) -> Pose:
    """Return a pose on a lattice, or not far from it."""
    if random.random() < 0.7:
        R = np.eye(3)[random.permutation(3)] * random.choice([-1.0, 1.0], 3)[:, None]
        R *= np.linalg.det(R)
    else:
        R = random_rotation(random)
    if random.random() < 0.2:
        turn = float(random.choice([1e-16, 1e-12, 1e-8, 1e-3]))
        c, s = np.cos(turn), np.sin(turn)
        R = R @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    p = scale * random.choice([0.0, 0.0, 0.25, 0.5, 0.5, 1.0, -0.5, -0.25, 0.75, 1.5], 3)
    if random.random() < 0.2:
        p = p + scale * random.choice([1e-17, 1e-15, 1e-12, 1e-9, 1e-4]) * random.normal(size=3)
    return R, p


class Pair:
    """Two bodies of a scene, registered in an order."""

    def __init__(self, bodies: tuple[Body, Body], order: tuple[int, int]) -> None:
        graph = geometry.SceneGraph()
        source, self._frames = graph.RegisterSource('pair'), {}
        for k in order:
            shape, modulus, hint = bodies[k]
            properties = geometry.ProximityProperties()
            if modulus == 0.0:
                geometry.AddRigidHydroelasticProperties(hint, properties)
            elif isinstance(shape, geometry.HalfSpace):
                add = geometry.AddCompliantHydroelasticPropertiesForHalfSpace
                add(hint, modulus, properties)
            else:
                geometry.AddCompliantHydroelasticProperties(hint, modulus, properties)
            instance = geometry.GeometryInstance(RigidTransform(), shape, 'body')
            instance.set_proximity_properties(properties)
            self._frames[k] = graph.RegisterFrame(source, geometry.GeometryFrame(f'{k}'))
            graph.RegisterGeometry(source, self._frames[k], instance)
        self._context = graph.CreateDefaultContext()
        self._port = graph.get_source_pose_port(source)
        self._query = graph.get_query_output_port().Eval(self._context)

    def asked(self, poses: Poses) -> tuple[ContactSurfaceResults, int]:
        """Return the surfaces, and how many pairs surely overlap without one.

        Of round bodies that touch, an iteration may find either.
        """
        vector = FramePoseVector()
        for k, (R, p) in enumerate(poses):
            vector.set_value(self._frames[k], RigidTransform(RotationMatrix(R), p))
        self._port.FixValue(self._context, vector)
        surfaces, others = self._query.ComputeContactSurfacesWithFallback()
        return surfaces, sum(pair.depth > pair.error_bound for pair in others)


def broken_law(surfaces: ContactSurfaceResults) -> str:
    """Return which law surfaces break, or an empty text."""
    for surface in surfaces:
        points, pressures, _ends = surface.polygon_arrays()
        areas = np.array([surface.area(k) for k in range(surface.num_faces())])
        centroids = np.array([surface.centroid(k) for k in range(surface.num_faces())])
        normals = np.array([surface.face_normal(k) for k in range(surface.num_faces())])
        numbers = (
            *(points, pressures, areas, centroids, normals, surface.force_on_M_W()),
            *(surface.torque_on_M_Wo_W(), surface.centroid(), surface.centre_of_pressure()),
        )
        if not all(np.isfinite(each).all() for each in numbers):
            return 'not finite'
        if pressures.min() < 0.0 or areas.min() <= 0.0:
            return 'a pressure below zero, or a face without area'
        if abs(areas.sum() - surface.total_area()) > 1e-9 * surface.total_area():
            return 'faces do not make up the area'
        if np.abs(np.linalg.norm(normals, axis=1) - 1.0).max() > 1e-12:
            return 'a normal that is not of length 1'
    return ''


class Question:
    """Two bodies, of about a scale [m], and what is asked of them."""

    def __init__(self, one: Body, two: Body, scale: float) -> None:
        self._bodies, self._scale = (one, two), scale
        self._modulus = max(one.modulus, two.modulus)
        self._pair, self._swapped = Pair((one, two), (0, 1)), Pair((one, two), (1, 0))

    def broken_law(self, poses: Poses, random: np.random.Generator, found: Counter[str]) -> str:
        """Return which law the answers at some poses break, or an empty text."""
        (surfaces, left), (others, also) = self._pair.asked(poses), self._swapped.asked(poses)
        found['surfaces'] += len(surfaces)
        found['overlaps without'] += left
        if law := broken_law(surfaces) or broken_law(others):
            return law
        numbers, other = self._numbers(surfaces), self._numbers(others)
        other[4:] *= -1.0  # force and torque are those on M
        faces = [[surface.num_faces() for surface in each] for each in (surfaces, others)]
        if left != also or faces[0] != faces[1] or (numbers != other).any():
            return 'it depends on who is M'
        return self._law_close_by(numbers, poses, random, found) if len(surfaces) else ''

    def _law_close_by(
        self, numbers: Floats, poses: Poses, random: np.random.Generator, found: Counter[str]
    ) -> str:
        """Return which law numbers break beside those of bodies that are almost the same."""
        first, second = poses
        near = list(poses_near(second, self._scale, random))
        if np.abs(self._around([near[-1]], poses) - numbers).max() <= ALLOWED:
            return ''
        found['jumps'] += 1
        one, two = self._bodies
        around = [self._around(near, poses)]
        for factor in (1.0 - HARDER, 1.0 + HARDER):
            pair = Pair((one._replace(modulus=factor * one.modulus), two), (0, 1))
            around.append(self._numbers(pair.asked((first, second))[0])[None])
        return 'it is not what it is close by' if is_alone(numbers, np.vstack(around)) else ''

    def _around(self, near: list[Pose], poses: Poses) -> Floats:
        """Return the numbers (k, 10) where the second body has other poses."""
        return np.array([self._numbers(self._pair.asked((poses[0], each))[0]) for each in near])

    def _numbers(self, surfaces: ContactSurfaceResults) -> Floats:
        return numbers_of(surfaces, self._scale, self._modulus)


def searched(random: np.random.Generator, found: Counter[str], broken: list[Any]) -> None:
    """Look at poses of one pair of bodies."""
    scale = float(10.0 ** random.integers(-3, 4))
    one = random_body(random, scale, soft=True)
    two = random_body(random, scale, soft=random.random() < 0.6)
    if random.random() < 0.2:
        two = Body(one.shape, float(random.choice([1.0, 2.0])) * one.modulus, one.hint)
    if isinstance(one.shape, geometry.HalfSpace) and isinstance(two.shape, geometry.HalfSpace):
        return
    try:
        question = Question(one, two, scale)
    except GeometryError:
        found['bodies refused'] += 1
        return
    for _ in range(_POSES):
        poses = random_pose(random, scale), random_pose(random, scale)
        found['poses'] += 1
        try:
            law = question.broken_law(poses, random, found)
        except Exception as error:  # whatever it is, it is found
            law = repr(error)
        if law:
            broken.append((law, one, two, poses))


def run(minutes: float, seed: int) -> int:
    """Search for some minutes; return 1 where a law was broken."""
    random, found = np.random.default_rng(seed), Counter[str]()
    broken: list[Any] = []
    end = time.monotonic() + 60.0 * minutes
    while time.monotonic() < end:
        searched(random, found, broken)
    print(', '.join(f'{name} {count}' for name, count in sorted(found.items())))
    for each in broken[:20]:
        print(*each)
    print(f'{len(broken)} broken')
    return int(bool(broken))
