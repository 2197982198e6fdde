"""The question about each state, and the job of a worker: a question about a scene."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.contacts import contact_columns
from drake_geom_ros.batch.joints import Arm, chain_of_arms, poses_of_arms, still_poses
from drake_geom_ros.geometry import (
    AccuracyLike,
    ArgumentError,
    PointDistanceResults,
    PoseError,
    SceneGraphContext,
    accuracy_of,
)
from drake_geom_ros.geometry.queries.joint_gradients import JointGradients, with_pairs
from drake_geom_ros.geometry.queries.joint_queries import NEAR, JointQueries
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.query_gradients import distance_gradients
from drake_geom_ros.geometry.queries.state_queries import (
    BlockAnswers,
    StateError,
    StateQueries,
)
from drake_geom_ros.math.array_types import Floats

Columns = dict[str, NDArray[Any]]

WANTS = ('collision', 'least', 'nearest', 'within', 'points', 'contacts')
_OF_PAIRS = (
    *('distance', 'error_bound', 'method'),
    *('nhat_BA_W', 'is_nhat_BA_W_unique', 'p_WCa', 'p_WCb'),
)
_STATES = 256  # between two looks at the flag that stops
_OF_POINTS = ('point_index', 'distance', 'error_bound', 'grad_W', 'is_grad_W_unique', 'p_GN')


@dataclass(frozen=True, eq=False)
class Question:
    """Query about each state: ``want`` is one of ``WANTS``, see ``evaluate``.

    ``collision`` is True if a pair overlaps or, with a finite ``max_distance`` [m], is not
    certified to be farther apart. ``least`` is the pair with the smallest lower bound, ``nearest``
    the ``count`` pairs with the smallest ones, ``within`` all pairs, ``points`` the distances to
    points (m, 3) [m] in World; these leave out pairs beyond ``max_distance``. ``contacts`` are the
    contact surfaces, and the overlapping pairs without one. Raises ArgumentError for invalid
    values.
    """

    want: str
    max_distance: float = math.inf
    accuracy: AccuracyLike = 'exact'
    count: int = 1
    points: Floats | None = None
    by_joints: bool = False  # the gradients of pairs by joint values, too

    def __post_init__(self) -> None:
        if self.want not in WANTS:
            raise ArgumentError(f'want={self.want!r} must be one of {", ".join(WANTS)}')
        object.__setattr__(self, 'accuracy', accuracy_of(self.accuracy))
        if math.isnan(self.max_distance):
            raise ArgumentError('max_distance must be a distance in metres or infinity, not NaN')
        if self.want == 'collision' and self.max_distance < 0.0:
            raise ArgumentError(
                f"max_distance={self.max_distance} with want='collision' must be a margin >= 0 "
                'in metres, or infinity to ask for overlap alone; what is as deep as that tells '
                "want='least'"
            )
        if self.want == 'contacts' and self.max_distance != math.inf:
            raise ArgumentError(
                f"max_distance={self.max_distance} with want='contacts' must be infinity: what "
                'does not overlap does not press'
            )
        if self.count < 1 or (self.count != 1 and self.want != 'nearest'):
            raise ArgumentError(f'count={self.count} must be >= 1, and goes with nearest')
        if self.by_joints and self.want not in ('least', 'nearest', 'within'):
            raise ArgumentError(
                f'by_joints gives gradients of pairs, which want={self.want!r} has not; '
                'least, nearest and within do'
            )
        if (self.want == 'points') != (self.points is not None):
            raise ArgumentError("want='points' and points go together")
        if self.points is not None:
            shape = self.points.shape
            if self.points.ndim != 2 or shape[1] != 3 or not np.isfinite(self.points).all():
                raise ArgumentError(f'points must be (m, 3), all finite; the shape is {shape}')

    @property
    def margin(self) -> float | None:
        """The margin of ``collision`` [m], None for overlaps alone."""
        return self.max_distance if math.isfinite(self.max_distance) else None

    @property
    def words(self) -> str:
        """The question in one line, equal for equal questions."""
        points = b'' if self.points is None else np.ascontiguousarray(self.points).tobytes()
        named = hashlib.sha256(points).hexdigest()[:16] if points else 'none'
        return (
            f'{self.want} max_distance={self.max_distance!r} accuracy={self.accuracy} '
            f'count={self.count} points={named}{" by_joints" * self.by_joints}'
        )


class JobQueries:
    """The queries that answer a job, for one thread; see ``Job.queries``.

    ``by_joints`` is the faster way, for valid states only; None: it cannot answer.
    """

    def __init__(self, scene: PackedScene, by_joints: JointQueries | None = None) -> None:
        self._scene, self.by_joints = scene, by_joints
        self._chain_rule: JointGradients | None = None

    @cached_property
    def by_poses(self) -> StateQueries:
        """The way for all states, made when it is first needed."""
        return StateQueries(self._scene)

    def chain_rule(self, arms: tuple[Arm, ...], columns: int) -> JointGradients:
        """Return the derivatives of frames by joint values, prepared when first needed."""
        if self._chain_rule is None:
            none = with_pairs(self._scene, np.zeros(0, dtype=np.int64))
            self._chain_rule = JointGradients(none, chain_of_arms(arms), columns, 'bound')
        return self._chain_rule


@dataclass(frozen=True, eq=False)
class Job:
    """A scene, a question, and the arms of states of joint values; without arms, states are poses.

    It consists of arrays and numbers, so it may go to another process.
    """

    scene: PackedScene
    question: Question
    arms: tuple[Arm, ...] = ()

    @classmethod
    def of(
        cls,
        context: SceneGraphContext,
        question: Question,
        ids: NDArray[np.int64],
        arms: tuple[Arm, ...] = (),
    ) -> tuple[Job, NDArray[np.int64]]:
        """Return a job about a context's scene, and its geometries' id values by place.

        ``ids`` (n,) are id values of the frames that states pose, those of the arms if there are
        any. Raises PoseError as ``PackedScene.of`` does.
        """
        if question.by_joints and not arms:
            raise ArgumentError('by_joints goes with joint values: states and joints, not poses')
        scene, geometry_ids = PackedScene.of(
            context,
            ids,
            still_poses(arms, ids),
            about_points=question.want == 'points',
            about_contacts=question.want == 'contacts',
        )
        return cls(scene, question, arms), geometry_ids

    @cached_property
    def digest(self) -> str:
        """A digest of the content."""
        digest = hashlib.sha256(f'{self.scene.digest} {self.question.words}'.encode())
        for arm in self.arms:
            trees = [getattr(arm.tree, field.name) for field in fields(arm.tree)]
            for array in (*trees, arm.X_WB, arm.links):
                digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def queries(self) -> JobQueries:
        """Return what answers the job, for one thread."""
        question, margin = self.question, self.question.margin
        padded = margin is None and self.scene.paddings.any()
        if question.want != 'collision' or not self.arms or padded:
            return JobQueries(self.scene)
        chain = chain_of_arms(self.arms)
        columns = 1 + max(int(arm.tree.leaders.max(initial=-1)) for arm in self.arms)
        limits = np.array([[-math.inf], [math.inf]]).repeat(columns, axis=1)
        by_joints = JointQueries(self.scene, chain, limits, question.accuracy, margin)
        return JobQueries(self.scene, by_joints)

    def answer(
        self,
        queries: JobQueries,
        states: Floats,
        stop: NDArray[np.int64],
        first: int = 0,
        *,
        shared: bool = False,
    ) -> Columns:
        """Return the answers about states, by column; geometries are places in the scene.

        There are ``counts`` (N,) if the number of answers differs between states. Raises PoseError
        for an invalid state, with its number, counted from ``first``. The points of one state may
        be ``shared`` among all threads of the process.
        """
        if queries.by_joints is not None:
            collides = _collisions(queries.by_joints, states, stop)
            if collides is not None:
                return {'collision': collides}
        poses = poses_of_arms(self.arms, states) if self.arms else states
        try:
            rows = np.ascontiguousarray(poses, dtype=np.float64)
            columns = self._answer(queries.by_poses, rows, stop, shared)
        except StateError as error:
            number = first + error.number
            raise PoseError(f'State {number} was refused: {error}') from None
        if self.question.by_joints:
            chain_rule = queries.chain_rule(self.arms, states.shape[1])
            columns['joint_gradient'] = self._by_joints(chain_rule, columns, states)
        return columns

    def _by_joints(self, chain_rule: JointGradients, columns: Columns, states: Floats) -> Floats:
        """Return the derivatives (k, q) of distances in columns by joint values (N, q)."""
        of_state = np.arange(len(states))
        if 'counts' in columns:
            of_state = np.repeat(of_state, columns['counts'])
        places = np.column_stack((columns['id_A'], columns['id_B']))
        rows = np.asarray(states, dtype=np.float64)
        return chain_rule.of_rows(rows, of_state, places, columns['gradient'])

    def _answer(
        self, queries: StateQueries, poses: Floats, stop: NDArray[np.int64], shared: bool
    ) -> Columns:
        question = self.question
        if question.want == 'collision':
            collides = queries.has_collisions(poses, question.accuracy, stop, question.margin)
            return {'collision': collides}
        if question.want == 'points':
            assert question.points is not None
            points = np.ascontiguousarray(question.points, dtype=np.float64)
            limit = question.max_distance
            return _columns(queries.points(poses, points, limit, stop, shared=shared))
        if question.want == 'contacts':
            return contact_columns(queries.contacts(poses, question.accuracy, stop))
        if question.want == 'within':
            return _columns(queries.within(poses, question.accuracy, question.max_distance, stop))
        limits = question.accuracy, question.max_distance, question.count
        columns = _columns(queries.nearest(poses, *limits, stop))
        return columns if question.want == 'nearest' else _one_each(columns)


def _collisions(
    queries: JointQueries, states: Floats, stop: NDArray[np.int64]
) -> NDArray[np.bool_] | None:
    """Return which states (N, c) collide; None if one of them is invalid."""
    rows = np.ascontiguousarray(states, dtype=np.float64)
    collides = np.empty(len(rows), dtype=np.bool_)
    for first in range(0, len(rows), _STATES):
        if stop[0]:
            raise InterruptedError(f'stopped after {first} of {len(rows)} states')
        verdicts = queries.verdicts(rows[first : first + _STATES])
        if (verdicts > NEAR).any():
            return None
        collides[first : first + _STATES] = verdicts == NEAR
    return collides


def _columns(answers: BlockAnswers) -> Columns:
    """Return copies of the columns of answers."""
    counts, results = answers
    if isinstance(results, PointDistanceResults):
        columns = {name: getattr(results, name).copy() for name in _OF_POINTS}
        return {'counts': counts, 'id_G': results.id_G, **columns}
    columns = {name: getattr(results, name).copy() for name in _OF_PAIRS}
    ids = {'id_A': results.id_A.copy(), 'id_B': results.id_B.copy()}
    return {'counts': counts, **ids, **columns, 'gradient': distance_gradients(results)}


def _one_each(columns: Columns) -> Columns:
    """Return columns with one row for each state, from those with none or one."""
    there = columns.pop('counts') > 0
    every = {}
    for name, values in columns.items():
        every[name] = np.zeros((len(there), *values.shape[1:]), dtype=values.dtype)
        if name in ('id_A', 'id_B'):
            every[name][:] = -1  # no place
        if name == 'distance':
            every[name][:] = np.inf
        every[name][there] = values
    return every
