"""``Checker``: fast checks of single states, for planners."""

from __future__ import annotations

import math
import threading
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.batch.distance_gradients import (
    ClearanceAndGradient,
    DistancesAndGradients,
    NearPairs,
    Pairs,
    fill_distances,
    numbers_of_pairs,
    on_all_cores,
)
from drake_geom_ros.batch.evaluation import context_of
from drake_geom_ros.batch.joints import Joints, chain_of_arms, poses_of_arms, still_poses
from drake_geom_ros.common.tables import SHOWN_ROWS, html_table
from drake_geom_ros.geometry import (
    AccuracyLike,
    ArgumentError,
    GeometryError,
    GeometryId,
    PoseError,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.geometry.queries.distance_rates import distance_rates
from drake_geom_ros.geometry.queries.joint_gradients import JointGradients, with_pairs
from drake_geom_ros.geometry.queries.joint_queries import (
    FREE,
    NEAR,
    NO_POSE,
    NO_STATE,
    OUTSIDE,
    JointQueries,
    NearestPair,
)
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.scene_mark import SceneMark
from drake_geom_ros.geometry.queries.state_queries import StateQueries, accuracy_in
from drake_geom_ros.math.array_types import Floats, Indices

_DOUBLES = np.dtype(np.float64)
_BLOCK = 1024  # states between two checks for Ctrl-C
_SELECTIONS = 8  # sets of pairs that a thread stays prepared for


class Clearance(NamedTuple):
    """The pair with the smallest lower bound in a state; ids and names are None without a pair.

    The smallest distance of all pairs is within ``error_bound`` of ``distance``, so every pair is
    certified to be at least ``lower_bound`` apart.
    """

    lower_bound: float  # [m] distance - error_bound
    distance: float  # [m]
    error_bound: float  # [m]
    id_A: GeometryId | None
    id_B: GeometryId | None
    name_a: str | None  # source::frame/geometry
    name_b: str | None


class Checker:
    """Checks whether states of a scene's joints are free, by one compiled call per state.

    A state q (c,) has one value for each of ``joints``, in [rad] or [m]. It is free if each value
    is within its limits, and each unfiltered pair of geometries is certified to be farther apart
    than ``margin`` [m]: its distance minus its error bound is larger. (So a state with a possible
    contact is not free for any margin.) The result equals, to the bit, that of ``evaluate`` for
    ``'collision'`` with the margin as ``max_distance``, and does not depend on earlier calls. The
    distance of two half spaces is their gap if they are opposed; otherwise they overlap.

    The checker uses the scene at its construction. After a change of the scene, its filters or the
    poses of frames that the joints do not move, it raises GeometryError: make a new one, which
    takes some milliseconds. Any number of threads may use one checker at once, each with its own
    memory; a context must not change meanwhile. Other processes need their own.
    """

    def __init__(
        self,
        scene_graph: SceneGraph | SceneGraphContext,
        joints: Joints,
        margin: float = 0.0,
        *,
        accuracy: AccuracyLike = '',
        ignore_limits: bool = False,
    ) -> None:
        """Prepare the scene, and compile missing kernels.

        ``accuracy`` is a level or a length [m], empty for the default of the scene. Raises
        ArgumentError for a margin that is no number >= 0, for an accuracy that is none, and if the
        joints move nothing that could collide; PoseError for frames that have no pose or are not
        in this scene.
        """
        number = as_number(margin)
        if number is None or not 0.0 <= number < math.inf:
            raise ArgumentError(f'margin={margin!r} must be a number >= 0, in metres')
        if not isinstance(joints, Joints):
            raise ArgumentError(
                f'joints={joints!r} must be batch.Joints, as Joints.of(loaded, names) returns it'
            )
        self.joints, self.margin = joints, number
        self._mark = SceneMark(scene_graph, joints.id_values)
        context = context_of(scene_graph)
        self.accuracy = accuracy_in(context, accuracy)
        self._scene, ids = PackedScene.of(
            context, joints.id_values, still_poses(joints.arms, joints.id_values)
        )
        if not self._scene.has_moving_pairs():
            raise ArgumentError(
                'these joints move no geometry that could collide with any other: each state '
                'would be free of what nobody looks at. The robot has no collision geometry in '
                'this scene, or filters leave all of it out'
            )
        inspector = QueryObject(context).inspector()
        self._ids = [GeometryId(value) for value in ids.tolist()]
        self._names = [inspector.full_name(id) for id in self._ids]
        self._chain = chain_of_arms(joints.arms)
        self._every_pair = np.concatenate((self._scene.pairs, self._scene.half_spaces))
        self._limits = np.array([joints.lower, joints.upper])
        if ignore_limits:
            self._limits = np.array([[-math.inf], [math.inf]]).repeat(joints.count, axis=1)
        self._shape = (joints.count,)
        self._own = threading.local()
        self.reason(np.clip(0.0, joints.lower, joints.upper))  # compiles

    def __reduce__(self) -> Any:
        raise TypeError(
            'a Checker is of this process, where it sees that its scene changes: make one in each'
        )

    def __repr__(self) -> str:
        return (
            f'<Checker: {self.joints.count} joints, {len(self._every_pair)} pairs, margin '
            f'{self.margin:g} m, accuracy {self.accuracy!r}>'
        )

    def _repr_html_(self) -> str:
        """Return the ten nearest pairs where all joints are nearest to 0, for notebooks."""
        q = np.clip(0.0, self.joints.lower, self.joints.upper)
        distance = self.distances_and_gradients(q).distance
        order = np.argsort(distance, kind='stable')[:SHOWN_ROWS].tolist()
        names = self.pair_names
        columns = {
            'A': [names[k][0] for k in order],
            'B': [names[k][1] for k in order],
            'distance [m]': [f'{distance[k]:.6g}' for k in order],
        }
        return html_table(f'{self!r}; the nearest {len(order)} at joint values near 0', columns)

    def free(self, q: ArrayLike) -> bool:
        """Return whether a state (c,) is free.

        Raises ArgumentError for another number of values, or one that is not finite, and
        GeometryError after a change of the scene.
        """
        verdict = self._queries().verdict(self._state(q))
        return self._checked(verdict, q) == FREE

    def clearance(self, q: ArrayLike) -> float:
        """Return a distance [m] that every pair is certified to have at least in a state (c,).

        It is the smallest lower bound, distance minus error bound, negative for an overlap, and
        infinite without a pair. Limits of joints are ignored. Raises as ``free``.
        """
        least = self._least(q)
        return least.distance - least.error_bound

    def nearest(self, q: ArrayLike) -> Clearance:
        """Return the pair with the smallest lower bound in a state (c,); raises as ``free``."""
        least = self._least(q)
        if least.verdict == FREE:
            return Clearance(math.inf, math.inf, 0.0, None, None, None, None)
        lower = least.distance - least.error_bound
        ids, names = self._ids, self._names
        a, b = least.a, least.b
        return Clearance(
            lower, least.distance, least.error_bound, ids[a], ids[b], names[a], names[b]
        )

    @property
    def pairs(self) -> Indices:
        """Id values (k, 2) of the pairs of geometries, in their fixed order.

        Pairs that filters leave out are missing. Pairs of half spaces are last.
        """
        ids = np.array([id.get_value() for id in self._ids], dtype=np.int64)
        pairs: Indices = ids[self._every_pair]
        return pairs

    @cached_property
    def _number_of(self) -> dict[tuple[int, int], int]:
        return {(a, b): number for number, (a, b) in enumerate(self.pairs.tolist())}

    @property
    def pair_names(self) -> list[tuple[str, str]]:
        """Names, ``source::frame/geometry``, of both geometries of each of ``pairs``."""
        return [(self._names[a], self._names[b]) for a, b in self._every_pair.tolist()]

    @cached_property
    def distance_rates(self) -> Floats:
        """Bounds (k, c) of the change of each pair's distance per unit of each joint value.

        For states q and p within the limits, ``|d(q) - d(p)| <= rates @ |q - p|`` for each of
        ``pairs``, in [m/rad] or [-]. It holds for convex bodies, and for all others while they
        stay apart (S. Schwarzer, M. Saha, J.-C. Latombe, *Exact collision checking of robot
        paths*, 2002). A rate is infinite where a joint turns a half space, or what an unlimited
        joint slides. With ``ignore_limits`` all joints are unlimited.
        """
        rates = distance_rates(self._scene, self._chain, self._limits)
        rates.setflags(write=False)
        return rates

    def clearance_and_gradient(self, q: ArrayLike) -> ClearanceAndGradient:
        """Return ``clearance`` and its derivatives by the joint values.

        Args:
            q: a state (c,), or N states (N, c), which are shared among all cores.

        Returns:
            ``clearance`` [m], a float or (N,), and ``gradient`` (c,) or (N, c) [m/rad] or [-], the
            derivatives of the distance of the nearest pair (envelope theorem; J. Danskin, *The
            Theory of Max-Min*, 1967). Its ``is_gradient_unique`` is False where there is no
            derivative. Without a pair the gradient is 0.

        Raises:
            ArgumentError, GeometryError, PoseError: as ``free``, with the number of the state.

        Example:
            >>> scene_graph = SceneGraph()
            >>> joints = Joints.of(load_scene('scenes/two_pandas.yaml', scene_graph))
            >>> checker = Checker(scene_graph, joints)
            >>> q = [0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2
            >>> clearance, gradient = checker.clearance_and_gradient(q)
            >>> gradient.shape
            (16,)
        """
        states, is_one = self._rows(q)
        clearances, unique = np.empty(len(states)), np.empty(len(states), dtype=np.bool_)
        gradients = np.empty(states.shape)

        def answer(number: int) -> None:
            state = states[number : number + 1]
            least = self._gradients().least(state)
            self._checked(least.verdict, state[0], '' if is_one else f'state {number}: ')
            clearances[number] = least.distance - least.error_bound
            gradients[number], unique[number] = least.gradient, least.is_unique

        if is_one:
            answer(0)
            one = ClearanceAndGradient(float(clearances[0]), gradients[0])
            one.is_gradient_unique = bool(unique[0])
            return one
        on_all_cores(len(states), answer)
        each = ClearanceAndGradient(clearances, gradients)
        each.is_gradient_unique = unique
        return each

    def distances_and_gradients(
        self,
        q: ArrayLike,
        pairs: Pairs | None = None,
        within: float = math.inf,
        *,
        out: DistancesAndGradients | None = None,
    ) -> DistancesAndGradients:
        """Return distances of pairs in a fixed order, and their derivatives by the joint values.

        Args:
            q: a state (c,), or N states (N, c), which are shared among all cores.
            pairs: k pairs of GeometryId or their values, in the order of the result; without it
                all of ``pairs``.
            within: [m] pairs that are certified to be farther apart get an infinite distance.
            out: arrays that are filled and returned, such as an earlier result.

        Returns:
            ``distance`` (k,) [m], ``error_bound`` (k,) [m], ``gradient`` (k, c) [m/rad] or [-] and
            ``is_gradient_unique`` (k,); for N states each has N rows. Two half spaces that cross
            are minus infinity apart.

        Raises:
            ArgumentError, GeometryError, PoseError: as ``free``; also for pairs that are unknown,
                filtered out or named twice, a ``within`` that is NaN, and an unfit ``out``.

        Example:
            >>> scene_graph = SceneGraph()
            >>> joints = Joints.of(load_scene('scenes/two_pandas.yaml', scene_graph))
            >>> checker = Checker(scene_graph, joints)
            >>> q = [0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2
            >>> near = checker.distances_and_gradients(q, within=0.1)
            >>> near.gradient.shape == (len(checker.pairs), 16)
            True
        """
        limit = _limit_of(within)
        states, is_one = self._rows(q)
        numbers = None
        if pairs is not None:
            numbers = numbers_of_pairs(pairs, self._number_of)
        count = len(self._every_pair) if numbers is None else len(numbers)
        shape = (count,) if is_one else (len(states), count)
        if out is None:
            out = DistancesAndGradients.empty(shape, self.joints.count)
        else:
            out.check(shape, self.joints.count)
        # The queries have chosen pairs in the order of all of them.
        order = None if numbers is None else np.argsort(numbers)

        def answer(number: int) -> None:
            state = states[number : number + 1]
            near = self._gradients(numbers).within(state, limit)
            self._checked(near.verdict, state[0], '' if is_one else f'state {number}: ')
            own = out if is_one else DistancesAndGradients(*(array[number] for array in out))
            fill_distances(near, order, own)

        if is_one:
            answer(0)
        else:
            on_all_cores(len(states), answer)
        return out

    def near_pairs(self, q: ArrayLike, within: float) -> NearPairs:
        """Return the pairs that may be within a distance [m], with derivatives by joint values.

        It is ``distances_and_gradients`` without the other pairs, and twice as fast for thousands.

        Args:
            q: a state (c,).
            within: [m] pairs that are certified to be farther apart are left out.

        Raises:
            ArgumentError, GeometryError, PoseError: as ``distances_and_gradients``.

        Example:
            >>> scene_graph = SceneGraph()
            >>> joints = Joints.of(load_scene('scenes/two_pandas.yaml', scene_graph))
            >>> checker = Checker(scene_graph, joints)
            >>> q = [0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2
            >>> near = checker.near_pairs(q, within=0.1)
            >>> bool((near.distance - near.error_bound <= 0.1).all())
            True
        """
        limit, state = _limit_of(within), self._state(q)
        near = self._gradients().within(state, limit)
        self._checked(near.verdict, state[0])
        return NearPairs(
            near.numbers.copy(),
            near.distance.copy(),
            near.error_bound.copy(),
            near.gradient.copy(),
            near.is_unique.copy(),
        )

    def free_each(self, states: ArrayLike) -> NDArray[np.bool_]:
        """Return whether each of the states (N, c) is free: (N,), computed by this thread.

        (``evaluate`` uses all cores.) Raises as ``free``, with the number of the state.
        """
        rows = _numbers(states)
        if rows.ndim != 2 or rows.shape[1:] != self._shape:
            raise ArgumentError(
                f'states has the shape {rows.shape}; it must be (N, {self.joints.count}), '
                f'{self._wanted()}'
            )
        queries, are_free = self._queries(), np.empty(len(rows), dtype=np.bool_)
        for first in range(0, len(rows), _BLOCK):
            verdicts = queries.verdicts(rows[first : first + _BLOCK])
            for k in np.flatnonzero(verdicts > OUTSIDE).tolist():
                self._checked(int(verdicts[k]), rows[first + k], f'state {first + k}: ')
            are_free[first : first + _BLOCK] = verdicts == FREE
        return are_free

    def reason(self, q: ArrayLike) -> str:
        """Return why a state (c,) is not free, empty if it is; raises as ``free``."""
        state = self._state(q)
        verdict = self._checked(self._queries().verdict(state), q)
        if verdict == OUTSIDE:
            (values,) = state
            lower, upper = self._limits
            return '; '.join(
                f'{self.joints.names[k]} = {values[k]:.6g} is outside its limits '
                f'[{lower[k]:.6g}, {upper[k]:.6g}]'
                for k in np.flatnonzero((values < lower) | (values > upper)).tolist()
            )
        if verdict == NEAR:
            near = self.nearest(q)
            if near.distance == -math.inf:
                return (
                    f'{near.name_a} and {near.name_b} are half spaces that overlap, as all do '
                    'that are not exactly opposed; filter the pair where that does not count'
                )
            return (
                f'{near.name_a} and {near.name_b} are not certified to be farther apart than '
                f'{self.margin:.6g} m: at least {near.lower_bound:.6g} m'
            )
        return ''

    def _least(self, q: ArrayLike) -> NearestPair:
        """Return the pair with the smallest lower bound in a state (c,); raises as ``free``."""
        state = self._state(q)
        least = self._queries().least(state)
        self._checked(least.verdict, q)
        return self._least_padded(state) if self._scene.paddings.any() else least

    def _least_padded(self, state: Floats) -> NearestPair:
        """Return the pair with the smallest lower bound of a padded scene in a state (1, c)."""
        if not hasattr(self._own, 'by_poses'):
            self._own.by_poses = StateQueries(self._scene)
        poses, never = poses_of_arms(self.joints.arms, state), np.zeros(1, dtype=np.int64)
        counts, pairs = self._own.by_poses.nearest(poses, self.accuracy, math.inf, 1, never)
        if not counts[0]:
            return NearestPair(FREE, math.inf, 0.0, 0, 0)
        return NearestPair(
            NEAR,
            float(pairs.distance[0]),
            float(pairs.error_bound[0]),
            int(pairs.id_A[0]),
            int(pairs.id_B[0]),
        )

    def _queries(self) -> JointQueries:
        """Return this thread's queries; raises GeometryError after a change of the scene."""
        self._check_mark()
        try:
            return self._own.queries  # type: ignore[no-any-return]
        except AttributeError:
            self._own.queries = JointQueries(
                self._scene, self._chain, self._limits, self.accuracy, self.margin
            )
            return self._own.queries  # type: ignore[no-any-return]

    def _check_mark(self) -> None:
        if not self._mark.is_of_now():
            raise GeometryError(
                'the scene was changed since this checker was prepared: what is in it, its '
                'filters, or the pose of a frame that the joints do not move. States are not '
                'answered of a scene that is no more; make a new Checker'
            )

    def _gradients(self, numbers: Indices | None = None) -> JointGradients:
        """Return this thread's queries with gradients, of all pairs or of those by ``numbers``."""
        self._check_mark()
        prepared = self._own.__dict__.setdefault('gradients', {})
        kind = None if numbers is None else np.sort(numbers).tobytes()
        if kind not in prepared:
            if len(prepared) > _SELECTIONS:
                prepared.clear()
            scene = self._scene
            if numbers is not None:
                scene = with_pairs(scene, np.sort(numbers))
            prepared[kind] = JointGradients(scene, self._chain, self.joints.count, self.accuracy)
        queries: JointGradients = prepared[kind]
        return queries

    def _rows(self, q: ArrayLike) -> tuple[Floats, bool]:
        """Return a state (c,) or states (N, c) as rows (N, c), a copy, and whether it is one."""
        if isinstance(q, np.ndarray) and q.dtype is _DOUBLES and q.shape == self._shape:
            return np.array(q, order='C', ndmin=2), True
        values = _numbers(q)
        if values.ndim == 1:
            return self._state(values), True
        if values.ndim != 2 or values.shape[1:] != self._shape:
            count = self.joints.count
            raise ArgumentError(
                f'states has the shape {values.shape}; it must be ({count},) or (N, {count}), '
                f'{self._wanted()}'
            )
        for number in np.flatnonzero(~np.isfinite(values).all(axis=1)).tolist():
            self._checked(NO_STATE, values[number], f'state {number}: ')
        return values, False

    def _state(self, q: ArrayLike) -> Floats:
        """Return a state (c,) as (1, c), a copy; raises ArgumentError for another shape."""
        if isinstance(q, np.ndarray) and q.dtype is _DOUBLES and q.shape == self._shape:
            return np.array(q, order='C', ndmin=2)
        values = _numbers(q)
        if values.shape != self._shape:
            raise ArgumentError(
                f'a state has the shape {values.shape}; it must be ({self.joints.count},), '
                f'{self._wanted()}'
            )
        return values[None]

    def _checked(self, verdict: int, q: ArrayLike, which: str = '') -> int:
        """Return a verdict on a state; raises ArgumentError or PoseError for an invalid one."""
        if verdict <= OUTSIDE:
            return verdict
        values = np.asarray(q, dtype=np.float64)
        if verdict == NO_STATE:
            bad = np.flatnonzero(~np.isfinite(values)).tolist()
            texts = ', '.join(f'{self.joints.names[k]} = {values[k]}' for k in bad)
            raise ArgumentError(f'{which}{texts}: joint values must be finite')
        assert verdict == NO_POSE
        raise PoseError(
            f'{which}{values.tolist()} would put a link where no pose may be, too far away'
        )

    def _wanted(self) -> str:
        return f'one value each for {", ".join(self.joints.names)}'


def _limit_of(within: float) -> float:
    """Return a distance [m] or infinity; raises ArgumentError for other values."""
    limit = as_number(within)
    if limit is None or math.isnan(limit):
        raise ArgumentError(f'within={within!r} must be a distance in metres or infinity')
    return limit


def _numbers(values: ArrayLike) -> Floats:
    """Return a contiguous copy of numbers as doubles; raises ArgumentError for other values."""
    try:
        numbers = np.array(values)
    except ValueError:
        raise ArgumentError(
            f'joint values must be numbers, all rows as long: {values!r}'
        ) from None
    if numbers.dtype.kind not in 'fiu':
        raise ArgumentError(f'joint values must be numbers; there are {numbers.dtype} {values!r}')
    return np.array(numbers, dtype=np.float64, order='C')
