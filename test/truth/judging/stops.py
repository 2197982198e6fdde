"""A cell of two arms, a base, a person and a sensed map, and the judge of answers about stops."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import (
    FrameId,
    FramePoseVector,
    GeometryId,
    GeometryInstance,
    OccupiedCells,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import compose, matrices_from_poses, poses_from_matrices
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.stopping import Braking, RobotState, StoppingCheck, StoppingQuestion, robots_of
from truth.references.braking import base_poses, progress

ARM = Path(__file__).parents[2] / 'batch/arm.urdf'
_CELL = """
name: cell
sources: [left, right, things, person]
robots:
  - {{name: left, urdf: {arm}, pose: {{position: [0, 0, 0.1]}}}}
  - {{name: right, urdf: {arm}, pose: {{position: [1.1, 0, 0.1]}}}}
frames:
  - {{name: trunk, source: person, pose: {{}}}}
  - {{name: arm, source: person, pose: {{}}}}
geometries:
  - {{name: floor, source: things, shape: {{type: half_space}}, pose: {{position: [0, 0, -0.05]}}}}
  - name: wall
    source: things
    pose: {{position: [0, 0.9, 0.5]}}
    shape: {{type: box, size: [3, 0.1, 1]}}
  - name: pole
    source: things
    pose: {{position: [0.5, -0.6, 0.5]}}
    shape: {{type: cylinder, radius: 0.05, length: 1}}
  - name: body
    source: person
    frame: trunk
    shape: {{type: capsule, radius: 0.15, length: 0.8}}
  - {{name: limb, source: person, frame: arm, shape: {{type: capsule, radius: 0.06, length: 0.5}}}}
"""
_SAMPLES = 48  # moments of one stop


class Moment(NamedTuple):
    """A random state of the cell."""

    positions: np.ndarray  # (c,) of both arms
    velocities: np.ndarray
    X_WB: np.ndarray  # (4, 4) of the base of the right arm
    twist: np.ndarray  # (3,) x, y, theta in its own axes
    people: np.ndarray  # (2, 7)


class StoppingCell:
    """The cell, states of it, and what is true of its stops; ``braking`` is that of all robots."""

    def __init__(self, braking: Braking, margin=0.02, max_speed=1.0, *, with_base=False):
        self.graph = SceneGraph()
        self.loaded = load_scene(_CELL.format(arm=ARM), self.graph)
        self.joints = Joints.of(self.loaded)
        self.robots = robots_of(self.joints)
        self.map = self._sensed().get_value()
        self.context = self.graph.CreateDefaultContext()
        self._judged = self.graph.CreateDefaultContext()  # without changes of shapes
        self.braking, self.margin, self.max_speed = braking, margin, max_speed
        self.with_base = with_base
        self.ids = {key: id.get_value() for key, id in self.loaded.geometries.items()}
        self.own = {name: self._of(name) for name in ('left', 'right', 'person')}
        self.names = {id: key for key, id in self.ids.items()}
        self.names[self.map] = ('sensed', 'world', 'cells')
        self.base = self.loaded.frames['right', 'base'].get_value()
        self.people = [self.loaded.frames['person', name].get_value() for name in ('trunk', 'arm')]
        self.check = self.checked()

    def _sensed(self):
        """Register a map that a sensor sees: a corner of two walls, behind the left arm."""
        row = 0.05 * np.arange(8)
        across = [[-0.55, y - 0.2, z + 0.3] for y in row for z in row]
        along = [[x - 0.55, -0.35, z + 0.3] for x in row for z in row]
        instance = GeometryInstance(
            RigidTransform(), OccupiedCells(0.05, np.array(across + along)), 'cells'
        )
        instance.set_proximity_properties(ProximityProperties())
        world = self.graph.model_inspector().world_frame_id()
        return self.graph.RegisterGeometry(self.graph.RegisterSource('sensed'), world, instance)

    def change_shape(self, id, shape):
        """Change the shape of a geometry by its id value, in the context."""
        inspector, it = self.graph.model_inspector(), GeometryId(id)
        owner = next(
            source
            for source in inspector.GetAllSourceIds()
            if inspector.BelongsToSource(it, source)
        )
        self.graph.ChangeShape(owner, it, shape, context=self.context)

    def _of(self, source):
        return [id for key, id in self.ids.items() if key[0] == source]

    def checked(self, **changes):
        """Return a check of both arms against all else, with other numbers of the questions."""
        asked = {'margin': self.margin, 'max_speed': self.max_speed, **changes}
        braking = asked.pop('braking', self.braking)
        questions = []
        for name in ('left', 'right'):
            own = braking
            if self.with_base and name == 'right':
                joints = tuple(n for n in self.joints.names if n.startswith('right'))
                one = braking.decelerations[0]
                names = (*joints, 'x', 'y', 'theta')
                own = Braking(
                    names, (one,) * len(names), (), braking.reaction_time, braking.category
                )
            questions.append(StoppingQuestion(own, self.own[name], **asked))
        return StoppingCheck(self.context, self.robots, questions)

    def moment(self, rng) -> Moment:
        """Return a random state; some joints stand."""
        lower, upper = self.joints.lower.clip(-2.5), self.joints.upper.clip(max=2.5)
        speeds = rng.uniform(-1.5, 1.5, self.joints.count) * (rng.random(self.joints.count) < 0.7)
        twist = rng.uniform(-1, 1, 3) * [1.0, 0.5, 1.5] * (rng.random(3) < 0.8)
        yaw = rng.uniform(-np.pi, np.pi)
        X_WB = np.eye(4)
        X_WB[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
        X_WB[:3, 3] = [rng.uniform(0.9, 1.5), rng.uniform(-0.4, 0.4), 0.1]
        people = np.zeros((2, 7))
        people[:, :2] = rng.uniform([-1.2, -1.5], [2.0, 0.6], (2, 2))
        people[:, 2] = rng.uniform(0.2, 1.2, 2)
        turns = rng.normal(size=(2, 4))
        people[:, 3:] = turns / np.linalg.norm(turns, axis=1)[:, None]
        if not self.with_base:
            twist, X_WB = np.zeros(3), self._first_base()
        return Moment(rng.uniform(lower, upper), speeds, X_WB, twist, people)

    def _first_base(self):
        return self.loaded.robots['right'].X_WB.GetAsMatrix4()

    def stops(self, moment, check=None, **options):
        """Return what the check says of a moment, for the left arm and for the right one."""
        ids = np.array([*self.people, self.base])
        R, p = moment.X_WB[None, :3, :3], moment.X_WB[None, :3, 3]
        rows = np.vstack((moment.people, poses_from_matrices(R, p)))
        self.context.UpdateFramePoses(FramePoseVector.FromArrays(ids, rows))
        X_PBs = [self.joints.arms[0].X_WB, rows[2]]
        R_WB = moment.X_WB[:3, :3]
        x, y, theta = moment.twist
        V = np.concatenate((R_WB @ [0.0, 0.0, theta], R_WB @ [x, y, 0.0]))
        states = []
        for k, robot in enumerate(self.robots):
            columns = [self.joints.names.index(name) for name in robot.joint_names]
            q, v = moment.positions[columns], moment.velocities[columns]
            V_PB = V if k and self.with_base else None
            states.append(RobotState(X_PBs[k], q, v, V_PB, options.get('age', 0.0)))
        return (check or self.check).stops(states, delay=options.get('delay', 0.0))

    # What is true.

    def worst(self, moment, number, went, seconds, asked=None):
        """Return the least clearance [m] of an arm's pairs in states of the cell.

        ``went`` (n, c + 1) [s] is for how long each joint, and the base, has gone on at its
        present speed, ``seconds`` (n,) how long the person walked, and what is in the map. From
        distances the margin and their way are taken off. ``asked`` is 'no other arm', 'the other
        arm', or None for both.
        """
        limit = self.margin + self.max_speed * float(seconds.max()) + 0.01
        poses = self._poses(moment, went)
        frames = np.concatenate((self.joints.id_values, self.people))
        frames, places = np.unique(frames, return_index=True)
        found = evaluate(
            self._judged, [FrameId(int(f)) for f in frames], poses[:, places], 'within', limit
        )
        rows = np.repeat(np.arange(len(poses)), np.diff(found.offsets))
        own = self.own[('left', 'right')[number]]
        walking = [*self.own['person'], self.map]  # what is in a map may walk, too
        a, b = np.asarray(found.id_A), np.asarray(found.id_B)
        is_own = np.isin(a, own) != np.isin(b, own)
        moving = self._moving(moment, number)
        is_own &= np.isin(a, moving) | np.isin(b, moving)
        other = self.own[('right', 'left')[number]]
        between_arms = np.isin(a, other) | np.isin(b, other)
        is_own &= {None: True, 'no other arm': ~between_arms, 'the other arm': between_arms}[asked]
        walks = np.isin(a, walking) | np.isin(b, walking)
        closed = np.where(walks, self.max_speed * seconds[rows], 0.0)
        left = np.asarray(found.distance) - self.margin - closed
        return float(left[is_own].min(initial=np.inf))

    def _moving(self, moment, number):
        """Return the geometries of an arm that move now."""
        robot, moving = self.robots[number], []
        columns = [self.joints.names.index(name) for name in robot.joint_names]
        needs = robot.tree.needs()
        base = number == 1 and self.with_base and moment.twist.any()
        moves = moment.velocities[columns] != 0.0
        frames = {}
        for link, frame in zip(robot.links.tolist(), robot.frame_ids.tolist(), strict=True):
            frames[frame] = base or bool(needs[link, moves[: needs.shape[1]]].any())
        frames[robot.root] = base
        inspector = self.graph.model_inspector()
        for name in self.own[('left', 'right')[number]]:
            if frames.get(inspector.GetFrameId(GeometryId(name)).get_value()):
                moving.append(name)
        return moving

    def _poses(self, moment, went):
        q = moment.positions + moment.velocities * went[:, :-1]
        poses = self.joints.poses(q)
        first = np.linalg.inv(self._first_base())
        of_right = np.isin(self.joints.id_values, [*self.robots[1].frame_ids, self.base])
        bases = base_poses(moment.X_WB, moment.twist, went[:, -1]) @ first
        count = len(poses)
        R_WMs, p_WMs = bases[:, None, :3, :3], bases[:, None, :3, 3]
        R, p = matrices_from_poses(poses[:, of_right].reshape(-1, 7))
        R, p = R.reshape(count, -1, 3, 3), p.reshape(count, -1, 3)
        R, p = compose(R_WMs, p_WMs, R, p)
        moved = poses_from_matrices(R.reshape(-1, 3, 3), p.reshape(-1, 3))
        poses[:, of_right] = moved.reshape(count, -1, 7)
        people = np.repeat(moment.people[None], len(went), axis=0)
        return np.concatenate((poses, people), axis=1)

    def times(self, moment):
        """Return the times [s] of each joint, and the base, to brake from the present speed."""
        rate = self.braking.decelerations[0]
        base = np.abs(moment.twist).max() / rate
        return np.append(np.abs(moment.velocities) / rate, base)

    def of_arm(self, number):
        """Return the mask (c + 1,) of the joints, and the base, of an arm."""
        names = self.robots[number].joint_names
        mine = np.isin(self.joints.names, names)
        return np.append(mine, number == 1 and self.with_base)

    def along_path(self, moment, number, share):
        """Return the progress (n, c + 1) and the times (n,) of one arm's stop along its path."""
        mine, times = self.of_arm(number), self.times(moment)
        braking, reaction = share * times[mine].max(), self.braking.reaction_time
        seconds = np.linspace(0.0, reaction + braking, _SAMPLES)
        on = progress(seconds, share, reaction, braking)
        return on[:, None] * mine, seconds

    def by_itself(self, moment, number, share, rng):
        """Return progress as ``along_path``, of both arms, or all joints, that stop anywhere."""
        times, reaction = self.times(moment), self.braking.reaction_time
        whole = np.zeros(len(times))
        for arm in range(2):
            mine = self.of_arm(arm)
            if self.braking.category == 1:
                whole[mine] = times[mine].max(initial=0.0)
            else:
                whole[mine] = times[mine]
        most = share * (reaction + 0.5 * share * whole)
        parts = rng.random((_SAMPLES, len(times)))
        parts[rng.random(parts.shape) < 0.3] = 1.0
        if self.braking.category == 1:  # each arm along its path
            for arm in range(2):
                mine = self.of_arm(arm)
                parts[:, mine] = parts[:, mine][:, :1]
        mine = self.of_arm(number)
        moves = np.append(moment.velocities != 0.0, moment.twist.any())
        last = reaction + share * whole[mine & moves].max(initial=0.0)
        return parts * most, np.full(_SAMPLES, last)
