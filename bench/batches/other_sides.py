"""Sides of ``bench.batches`` beside pydrake's: Coal with Pinocchio, and MuJoCo, each in a loop.

Both get the shapes and the pairs of geometries that the other sides have.
"""

from __future__ import annotations

from typing import Any

import coal  # Pinocchio hands shapes of it over: it has to know their types
import mujoco
import numpy as np
import pinocchio

from truth.peers.coal_peer import coal_shape
from truth.peers.mujoco_peer import FARTHEST, add_geom

assert coal
Name = tuple[str, str, str]


class CoalSide:
    """Pinocchio poses the arms and has Coal ask all pairs: one call a state."""

    name = f'Pinocchio {pinocchio.__version__} with Coal {coal.__version__}'

    def __init__(self, ours: Any) -> None:
        self._model = pinocchio.Model()
        for arm, robot in ours.loaded.robots.items():
            # Two arms of one URDF: names of one model are all different.
            text = robot.urdf.read_text().replace('"panda_', f'"{arm}_panda_')
            one, X_WB = pinocchio.buildModelFromXML(text), pinocchio.SE3(robot.X_WB.GetAsMatrix4())
            world = self._model.getFrameId('universe')
            self._model = pinocchio.appendModel(self._model, one, world, X_WB)
        self._shapes = pinocchio.GeometryModel()
        inspector, poses = ours.scene_graph.model_inspector(), ours.standing_poses()
        numbers: dict[Name, int] = {}
        for name, id in ours.loaded.geometries.items():
            if name in poses:
                joint, X_JG = 0, pinocchio.SE3(poses[name].GetAsMatrix4())
            else:
                frame = self._model.frames[self._model.getFrameId(f'{name[0]}_{name[1]}')]
                X_FG = pinocchio.SE3(inspector.GetPoseInFrame(id).GetAsMatrix4())
                joint, X_JG = frame.parentJoint, frame.placement * X_FG
            shape = coal_shape(inspector.GetShape(id))
            body = pinocchio.GeometryObject('/'.join(name), joint, X_JG, shape)
            numbers[name] = self._shapes.addGeometryObject(body)
        for pair in ours.pairs():
            a, b = sorted(numbers[name] for name in pair)
            self._shapes.addCollisionPair(pinocchio.CollisionPair(a, b))
        self._data, self._answers = self._model.createData(), self._shapes.createData()
        self._columns = self._layout(ours)

    def _layout(self, ours: Any) -> list[int]:
        """Return which column of a state each position of the model takes."""
        columns = []
        for name in list(self._model.names)[1:]:
            arm, _, joint = name.partition('_')
            leader = joint.replace('finger_joint2', 'finger_joint1')  # which the other mimics
            columns.append(ours.joints.names.index(f'{arm}::{leader}'))
        return columns

    def _arguments(self, q: np.ndarray) -> tuple[Any, ...]:
        return self._model, self._data, self._shapes, self._answers, q

    def least(self, states: np.ndarray) -> np.ndarray:
        """Return the least signed distance [m] of each state."""
        found = np.empty(len(states))
        for k, q in enumerate(states[:, self._columns]):
            nearest = pinocchio.computeDistances(*self._arguments(q))
            found[k] = self._answers.distanceResults[nearest].min_distance
        return found

    def collisions(self, states: np.ndarray) -> np.ndarray:
        """Return which states collide; each ends at its first contact."""
        columns = states[:, self._columns]
        return np.array([pinocchio.computeCollisions(*self._arguments(q), True) for q in columns])


class MujocoSide:
    """MuJoCo's collision phase in a loop, as ``rollout`` runs it at each step.

    Links are free bodies, posed by our kinematics, whose time is not counted.
    """

    name = f'MuJoCo {mujoco.__version__}'

    def __init__(self, ours: Any) -> None:
        self._ours = ours
        spec, inspector = mujoco.MjSpec(), ours.scene_graph.model_inspector()
        poses, geoms, bodies = ours.standing_poses(), {}, {}
        for frame in ours.joints.frame_ids:  # in the order of the poses
            body = spec.worldbody.add_body(
                name=f'{inspector.GetName(frame)}#{frame.get_value()}',
                mass=1.0,
                inertia=[1.0, 1.0, 1.0],
                explicitinertial=True,
            )
            body.add_freejoint()
            bodies[frame] = body
        owner: dict[Name, str] = {}
        for name, id in ours.loaded.geometries.items():
            fixed = name in poses
            body = spec.worldbody if fixed else bodies[inspector.GetFrameId(id)]
            geom = add_geom(spec, body, inspector.GetShape(id), '/'.join(name))
            X = poses[name] if fixed else inspector.GetPoseInFrame(id)
            geom.pos, geom.quat = X.translation(), X.rotation().ToQuaternion().wxyz()
            geoms[name], owner[name] = '/'.join(name), 'world' if fixed else body.name
        asked = {frozenset(owner[name] for name in pair) for pair in ours.pairs()}
        names = sorted(set(owner.values()))
        for i, a in enumerate(names):
            for b in names[i + 1 :]:
                if frozenset((a, b)) not in asked:
                    spec.add_exclude(bodyname1=a, bodyname2=b)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._pairs = [[self._model.geom(geoms[n]).id for n in pair] for pair in ours.pairs()]

    def _pose(self, poses: np.ndarray) -> None:
        """Pose the links by x y z qx qy qz qw (n, 7)."""
        self._data.qpos[:] = poses[:, [0, 1, 2, 6, 3, 4, 5]].ravel()
        mujoco.mj_kinematics(self._model, self._data)

    def least(self, states: np.ndarray) -> np.ndarray:
        """Return the least signed distance [m] of each state; the best one bounds the others."""
        found = np.empty(len(states))
        for k, poses in enumerate(self._ours.joints.poses(states)):
            self._pose(poses)
            best = FARTHEST
            for a, b in self._pairs:
                best = min(best, mujoco.mj_geomDistance(self._model, self._data, a, b, best, None))
            found[k] = best
        return found

    def collisions(self, states: np.ndarray) -> np.ndarray:
        """Return which states collide: all contacts are found."""
        found = np.empty(len(states), dtype=bool)
        for k, poses in enumerate(self._ours.joints.poses(states)):
            self._pose(poses)
            mujoco.mj_collision(self._model, self._data)
            found[k] = self._data.ncon > 0
        return found
