"""The service ``evaluate_states``: many joint values in one call, as a planner asks.

It runs in a thread of its own, on a view of the scene of when it was called. What it answers is
that of ``drake_geom_ros.batch``, to the bit; here it gets names and the form of a message.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.batch.evaluation import evaluate
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.results import LeastDistances, PairsOfStates
from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError, SceneGraphContext, accuracy_of
from drake_geom_ros.live.conversions.fields import floats, uint8s, uint32s, unsigned
from drake_geom_ros.live.conversions.request_types import EvaluateStatesRequest
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.services.joint_views import view_of_joints
from drake_geom_ros.math.array_types import Flags, Floats

FREE, TOO_NEAR, OUTSIDE_LIMITS = range(3)
WANTS = {'collision': 'collision', 'least': 'least', 'near': 'within'}  # and as batches call it
_SIZES = {'collision': 2, 'least': 34, 'near': 38}  # [bytes] of a state, at least
_PAIR_SIZE = 32  # [bytes] of a pair of `near`
# Of states that end at the first that is not free so many are evaluated first, then twice as many.
_FIRST_BLOCK, _LAST_BLOCK = 64, 8192


class _Evaluated(NamedTuple):
    """The answers of states that were evaluated."""

    is_free: Flags
    pairs: LeastDistances | PairsOfStates | None


def evaluate_states(live: LiveScene, request: EvaluateStatesRequest, response: Any) -> None:
    """Answer for each of many states of joints; raises RuntimeError to refuse all of them."""
    _check(request)
    view, joints, _ = view_of_joints(live, request.poses, list(request.joint_names))
    states = _states(request, joints, live.most_megabytes)
    inside = np.full(len(states), True)
    if not request.ignore_limits:
        inside &= np.all((states >= joints.lower) & (states <= joints.upper), axis=1)
    count, evaluated = _evaluate(view.context, request, joints, states, inside)
    _refuse_too_many_pairs(evaluated, live.most_megabytes)
    _fill(response, request.want, inside[:count], evaluated)
    response.scene_version = view.moment.version
    response.oldest_pose_age = view.moment.oldest_pose_age
    view.beside.fill(response)
    response.stale_frames = view.stale_frames()
    response.message = view.reservations()


def _check(request: EvaluateStatesRequest) -> None:
    """Raise ArgumentError for a request that cannot be meant."""
    if request.want not in WANTS:
        raise ArgumentError(f'want is {request.want!r}; it must be one of {", ".join(WANTS)}')
    if not 0.0 <= request.clearance < math.inf:
        raise ArgumentError(f'clearance is {request.clearance}; it must be >= 0 [m] and finite')
    if not request.max_distance >= 0.0 or (request.max_distance and request.want != 'near'):
        raise ArgumentError(
            f'max_distance is {request.max_distance} with want {request.want!r}; it must be >= 0 '
            '[m] (0 stands for infinity), and goes with `near`'
        )
    if request.accuracy:
        accuracy_of(request.accuracy)


def _states(request: EvaluateStatesRequest, joints: Joints, most_megabytes: float) -> Floats:
    """Return the states (n, q) of a request; raises ArgumentError for what they cannot be."""
    positions = np.asarray(request.positions, dtype=np.float64)
    if positions.size % joints.count:
        raise ArgumentError(
            f'positions holds {positions.size} numbers for {counted(joints.count, "joint")}; it '
            'must hold one for each joint of each state'
        )
    states = positions.reshape(-1, joints.count)
    bad = np.flatnonzero(~np.isfinite(states).all(axis=1))
    if bad.size:
        raise ArgumentError(f'state {bad[0]} of positions has a number that is not finite')
    size = _SIZES[request.want]
    if len(states) * size > 1e6 * most_megabytes:
        raise ArgumentError(
            f'an answer for {len(states)} states takes {len(states) * size / 1e6:.1f} MB, and the '
            f'parameter max_answer_size allows {most_megabytes:g} MB: ask for at most '
            f'{int(1e6 * most_megabytes / size)} states at once'
        )
    return states


def _evaluate(
    context: SceneGraphContext,
    request: EvaluateStatesRequest,
    joints: Joints,
    states: Floats,
    inside: Flags,
) -> tuple[int, _Evaluated]:
    """Return how many states count, and the answers of those of them that are inside limits."""
    if not request.stop_at_first:
        return len(states), _answers(context, request, joints, states[inside])
    count, free = _to_first(context, request, joints, states, inside)
    if request.want == 'collision':  # which that told
        return count, _Evaluated(free[inside[:count]], None)
    return count, _answers(context, request, joints, states[:count][inside[:count]])


def _to_first(
    context: SceneGraphContext,
    request: EvaluateStatesRequest,
    joints: Joints,
    states: Floats,
    inside: Flags,
) -> tuple[int, Flags]:
    """Return how many states there are up to the first that is not free, and which are free.

    That one counts too.
    """
    first, size = 0, _FIRST_BLOCK
    while first < len(states):
        last = min(first + size, len(states))
        free = inside[first:last].copy()
        free[free] = _are_free(context, request, joints, states[first:last][free])
        if not free.all():
            count = first + int(np.argmin(free)) + 1
            return count, np.arange(count) < count - 1
        first, size = last, min(2 * size, _LAST_BLOCK)
    return len(states), np.full(len(states), True)


def _are_free(
    context: SceneGraphContext, request: EvaluateStatesRequest, joints: Joints, states: Floats
) -> Flags:
    """Return of which states (n, q) every pair is certified to be farther apart than clearance."""
    collides = evaluate(
        context,
        states=states,
        joints=joints,
        want='collision',
        max_distance=request.clearance,
        accuracy=request.accuracy,
    )
    return ~np.asarray(collides, dtype=np.bool_)


def _answers(
    context: SceneGraphContext, request: EvaluateStatesRequest, joints: Joints, states: Floats
) -> _Evaluated:
    """Return the answers of states, all of them inside limits."""
    if request.want == 'collision':
        return _Evaluated(_are_free(context, request, joints, states), None)
    answers = evaluate(
        context,
        states=states,
        joints=joints,
        want=WANTS[request.want],
        max_distance=request.max_distance or math.inf,
        accuracy=request.accuracy,
    )
    if isinstance(answers, LeastDistances):
        return _Evaluated(answers.distance - answers.error_bound > request.clearance, answers)
    assert isinstance(answers, (LeastDistances, PairsOfStates))
    return _Evaluated(_are_free(context, request, joints, states), answers)


def _refuse_too_many_pairs(answers: _Evaluated, most_megabytes: float) -> None:
    if isinstance(answers.pairs, PairsOfStates):
        megabytes = len(answers.pairs.distance) * _PAIR_SIZE / 1e6
        if megabytes > most_megabytes:
            raise ArgumentError(
                f'an answer of {len(answers.pairs.distance)} pairs takes {megabytes:.1f} MB, and '
                f'the parameter max_answer_size allows {most_megabytes:g} MB: ask with a smaller '
                'max_distance, or for fewer states'
            )


def _fill(response: Any, want: str, inside: Flags, evaluated: _Evaluated) -> None:
    """Fill an answer with what was found of the states that are inside limits."""
    free, reason = inside.copy(), np.full(len(inside), OUTSIDE_LIMITS, dtype=np.uint8)
    free[inside] = evaluated.is_free
    reason[inside] = np.where(evaluated.is_free, FREE, TOO_NEAR)
    response.count, response.free, response.reason = len(inside), free.tolist(), uint8s(reason)
    response.first_not_free = -1 if free.all() else int(np.argmin(free))
    pairs = evaluated.pairs
    if isinstance(pairs, LeastDistances):
        distance, bound = np.full((2, len(inside)), math.nan)
        ids = np.zeros((2, len(inside)), dtype=np.int64)
        distance[inside], bound[inside] = pairs.distance, pairs.error_bound
        ids[:, inside] = pairs.id_A, pairs.id_B
        _fill_pairs(response, distance, bound, ids[0], ids[1])
    elif pairs is not None:
        counts = np.zeros(len(inside) + 1, dtype=np.int64)
        counts[1:][inside] = np.diff(pairs.offsets)
        response.offsets = uint32s(np.cumsum(counts))
        _fill_pairs(response, pairs.distance, pairs.error_bound, pairs.id_A, pairs.id_B)


def _fill_pairs(response: Any, distance: Floats, bound: Floats, id_A: Any, id_B: Any) -> None:
    response.distance, response.error_bound = floats(distance), floats(bound)
    response.id_a, response.id_b = unsigned(id_A), unsigned(id_B)
