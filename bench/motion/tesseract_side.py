"""Tesseract's continuous contact manager, Bullet's, on the arms of the bench and on pairs.

It casts each moving body: it asks about the convex hull of the body at the start of a segment and
at its end. Poses are put into its own containers before the clock starts.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import tesseract_robotics
import yaml
from numpy.typing import NDArray
from tesseract_robotics import tesseract_collision, tesseract_common, tesseract_geometry

from bench.batches.ours import Ours
from drake_geom_ros import geometry
from drake_geom_ros.math.batched import matrices_from_poses

Floats = NDArray[np.float64]
NAME = 'tesseract'
MANAGER = 'BulletCastBVHManager'


def tesseract_shape(shape: Any) -> Any:
    """Return Tesseract's shape, or None where it has none."""
    if isinstance(shape, geometry.Sphere):
        return tesseract_geometry.Sphere(shape.radius())
    if isinstance(shape, geometry.Box):
        return tesseract_geometry.Box(shape.width(), shape.depth(), shape.height())
    if isinstance(shape, geometry.Cylinder):
        return tesseract_geometry.Cylinder(shape.radius(), shape.length())
    if isinstance(shape, geometry.Capsule):
        return tesseract_geometry.Capsule(shape.radius(), shape.length())
    return None


def poses_of(matrices: Floats) -> Any:
    """Return poses (n, 4, 4) in its own container."""
    found = tesseract_common.VectorIsometry3d()
    for matrix in matrices:
        found.append(tesseract_common.Isometry3d(np.asfortranarray(matrix)))
    return found


class CastManager:
    """Bodies by name, each of shapes with their poses on it; ``moving`` ones are cast."""

    def __init__(
        self,
        bodies: Mapping[str, list[tuple[Any, Floats]]],
        moving: list[str],
        filtered: list[tuple[str, str]],
    ) -> None:
        (library,) = (
            Path(tesseract_robotics.__file__).parents[1] / 'tesseract_robotics.libs'
        ).glob('libtesseract_collision_bullet_factories*')
        plugins = {
            'search_paths': [str(library.parent)],
            'search_libraries': [library.name.removeprefix('lib').removesuffix('.so')],
            'continuous_plugins': {
                'default': MANAGER,
                'plugins': {MANAGER: {'class': f'{MANAGER}Factory'}},
            },
        }
        text = yaml.safe_dump({'contact_manager_plugins': plugins})
        self._locator = tesseract_common.GeneralResourceLocator()
        self._factory = tesseract_collision.ContactManagersPluginFactory(text, self._locator)
        self._manager = self._factory.createContinuousContactManager(MANAGER)
        for name, shapes in bodies.items():
            kept = tesseract_geometry.GeometriesConst()
            for shape, _ in shapes:
                kept.append(tesseract_shape(shape))
            poses = poses_of(np.array([X for _, X in shapes]))
            self._manager.addCollisionObject(name, 0, kept, poses, True)
        self._manager.setActiveCollisionObjects(moving)
        self._manager.setDefaultCollisionMarginData(0.0)
        config = tesseract_collision.ContactManagerConfig()
        matrix = tesseract_common.AllowedCollisionMatrix()
        for one, other in filtered:
            matrix.addAllowedCollision(one, other, 'filtered')
        config.acm = matrix
        config.acm_override_type = tesseract_collision.ACMOverrideType_ASSIGN
        self._manager.applyContactManagerConfig(config)
        self._moving = moving
        self._request = tesseract_collision.ContactRequest(
            tesseract_collision.ContactTestType_FIRST
        )

    def stand(self, names: list[str], matrices: Floats) -> None:
        """Put bodies that do not move where they are."""
        for name, matrix in zip(names, matrices, strict=True):
            pose = tesseract_common.Isometry3d(np.asfortranarray(matrix))
            self._manager.setCollisionObjectsTransform(name, pose)

    def is_free(self, states: list[Any]) -> bool:
        """Tell whether no cast between two of some states, each poses of what moves, touches."""
        for start, end in pairwise(states):
            self._manager.setCollisionObjectsTransform(self._moving, start, end)
            found = tesseract_collision.ContactResultMap()
            self._manager.contactTest(found, self._request)
            if found.count():
                return False
        return True


class TesseractArms:
    """The arms and what stands around them; ``ours`` loses the ellipsoids, unknown to it."""

    def __init__(self, ours: Ours) -> None:
        inspector = ours.scene_graph.model_inspector()
        unknown = [
            id
            for id in ours.loaded.geometries.values()
            if tesseract_shape(inspector.GetShape(id)) is None
        ]
        every = list(ours.loaded.geometries.values())
        ours.exclude(geometry.GeometrySet(unknown), geometry.GeometrySet(every))
        standing, bodies, owner = set(ours.standing), {}, {}
        for name, id in ours.loaded.geometries.items():
            if id in unknown:
                continue
            shape = inspector.GetShape(id)
            owner[id] = '::'.join(name) if id in standing else '::'.join(name[:2])
            X = np.eye(4) if id in standing else inspector.GetPoseInFrame(id).GetAsMatrix4()
            bodies.setdefault(owner[id], []).append((shape, X))
        frames = {frame.get_value(): '::'.join(name) for name, frame in ours.loaded.frames.items()}
        named = [frames[id] for id in ours.joints.id_values.tolist()]
        self._columns = [k for k, name in enumerate(named) if name in bodies]
        moving = [named[k] for k in self._columns]
        free = {frozenset((owner[a], owner[b])) for a, b in inspector.GetCollisionCandidates()}
        names = sorted(bodies)
        filtered = [
            (a, b)
            for k, a in enumerate(names)
            for b in names[k + 1 :]
            if frozenset((a, b)) not in free
        ]
        self.manager = CastManager(bodies, moving, filtered)
        there = {
            name: X.GetAsMatrix4()
            for name, X in (('::'.join(n), X) for n, X in ours.standing_poses().items())
            if name in bodies
        }
        self.manager.stand(list(there), np.array(list(there.values())))
        self._joints = ours.joints

    def states(self, path: Floats, segments: int) -> list[Any]:
        """Return the poses of all links, so many segments long, in its containers."""
        times = np.linspace(0.0, 1.0, segments + 1)[:, None]
        rows = np.clip(path[0] + times * (path[1] - path[0]), *np.sort(path, axis=0))
        poses = self._joints.poses(rows)[:, self._columns]
        matrices = np.tile(np.eye(4), (*poses.shape[:2], 1, 1))
        for k, state in enumerate(poses):
            matrices[k, :, :3, :3], matrices[k, :, :3, 3] = matrices_from_poses(state)
        return [poses_of(state) for state in matrices]
