"""Regions of joint values around a state that are free: certified, or probably."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.batch import Checker
from drake_geom_ros.geometry import ArgumentError, GeometryError
from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.optimization.polyhedron import HPolyhedron

_HALVINGS = 12  # of the way from a free state to one in collision
_MOST_PLANES = 64  # of one round
# Cosine of a clearance's gradient and the way to a collision, below which the way is the normal.
_FACING = 0.2


class FreeRegion(NamedTuple):
    """A polytope of joint values around a state, and what is certified of it."""

    polytope: HPolyhedron
    certificate: Literal['certified', 'probabilistic']
    collision_fraction: float  # at most this part of the volume is not free; 0 where certified
    confidence: float  # the probability of that; 1 where certified


def certified_free_ball(checker: Checker, q: ArrayLike, margin: float | None = None) -> float:
    """Return a radius r such that every state nearer to q than r is free.

    It is proved by bounds of motion (``Checker.distance_rates``): each pair stays farther apart
    than the margin for all states p with ``|p - q| < r`` (Euclidean norm of joint values, in [rad]
    and [m]) that are within the joint limits.

    Args:
        checker: a ``batch.Checker``.
        q: a state (c,) within its limits.
        margin: [m] smallest allowed distance; None: that of the checker.

    Returns:
        The radius. It is 0 where nothing is proved, not even that q is free.

    Raises:
        ArgumentError: a state that is invalid or beyond its limits, a margin that is no number
            >= 0.

        >>> scene_graph = SceneGraph()
        >>> joints = Joints.of(load_scene('scenes/two_pandas.yaml', scene_graph))
        >>> q = [0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2
        >>> certified_free_ball(Checker(scene_graph, joints), q) >= 0.0
        True
    """
    slack = _slack(checker, q, margin)
    if not (slack > 0.0).all():
        return 0.0
    lengths = np.linalg.norm(checker.distance_rates, axis=1)
    moving = lengths > 0.0
    return _rounded_down(float((slack[moving] / lengths[moving]).min(initial=math.inf)))


def certified_free_box(
    checker: Checker, q: ArrayLike, margin: float | None = None
) -> tuple[Floats, Floats]:
    """Return the corners (c,), lower and upper, of a box around q in which every state is free.

    The box is proved as ``certified_free_ball`` and is within the joint limits. Its widths grow in
    proportion to the ranges of the joints, and then one after another as far as the proof allows.

    Args and errors are those of ``certified_free_ball``. Raises GeometryError where nothing is
    proved of q.
    """
    slack, rates = _slack(checker, q, margin), checker.distance_rates
    if not (slack > 0.0).all() or np.isinf(rates).any():
        raise GeometryError(
            'no free box is proved around this state: a pair is not certified to be farther '
            f'apart than the margin, or its distance changes at an unlimited rate; its clearance '
            f'is {checker.clearance(q):.6g} m'
        )
    state = np.asarray(q, dtype=np.float64)
    lower, upper = checker.joints.lower, checker.joints.upper
    farthest = np.maximum(state - lower, upper - state)
    ranges = np.where(np.isfinite(upper - lower), upper - lower, 2.0 * math.pi)
    moving = rates.any(axis=1)
    rates, slack = rates[moving], slack[moving]
    speeds = rates @ ranges
    widths = np.minimum(ranges * _rounded_down((slack / speeds).min(initial=1.0)), farthest)
    for column in range(len(widths)):
        used = rates[:, column] > 0.0
        left = slack[used] - rates[used] @ widths
        extra = _rounded_down((left / rates[used, column]).min(initial=math.inf))
        widths[column] = min(widths[column] + max(extra, 0.0), farthest[column])
    return np.maximum(state - widths, lower), np.minimum(state + widths, upper)


def free_region(
    checker: Checker,
    q: ArrayLike,
    certificate: Literal['certified', 'probabilistic'] = 'certified',
    *,
    domain: HPolyhedron | None = None,
    collision_fraction: float = 0.01,
    confidence: float = 0.99,
    most_rounds: int = 100,
    seed: int = 0,
) -> FreeRegion:
    """Return a polytope of joint values around a free state.

    ``'certified'`` gives the box of ``certified_free_box``. ``'probabilistic'`` begins with a
    ``domain`` and cuts off collisions by planes, similar to IRIS-ZO (P. Werner, R. Cheng,
    T. Stewart, R. Tedrake, D. Rus, *Superfast configuration-space convex set computation*, 2025).
    It ends with a round of n fresh samples without a collision, where
    ``(1 - collision_fraction)^n`` is at most the allowed error of the round; the errors of all
    rounds sum up to ``1 - confidence``. Samples are made by hit and run, which approaches the
    uniform distribution.

    Args:
        checker: a ``batch.Checker``, whose margin and limits define what is free.
        q: a free state (c,).
        certificate: ``'certified'`` or ``'probabilistic'``.
        domain: where a probabilistic region begins; None: the limits of the joints.
        collision_fraction: largest allowed fraction of the volume that is not free.
        confidence: probability that the fraction is kept.
        most_rounds: limit of rounds of samples.
        seed: of the samples.

    Raises:
        ArgumentError: an unknown certificate, values out of range, joints without limits and
            without a ``domain``, or one that does not hold the state.
        GeometryError: a state that is not free, or no region within ``most_rounds``.
    """
    if certificate not in ('certified', 'probabilistic'):
        raise ArgumentError(f"certificate={certificate!r} must be 'certified' or 'probabilistic'")
    if certificate == 'certified':
        box = HPolyhedron.MakeBox(*certified_free_box(checker, q))
        return FreeRegion(box, certificate, 0.0, 1.0)
    for name, value in (('collision_fraction', collision_fraction), ('confidence', confidence)):
        number = as_number(value)
        if number is None or not 0.0 < number < 1.0:
            raise ArgumentError(f'{name}={value!r} must be above 0 and below 1')
    region = _domain(checker, domain)
    if reason := checker.reason(q):
        raise GeometryError(f'the state is not free, so no region is grown around it: {reason}')
    centre, rng = np.array(q, dtype=np.float64), np.random.default_rng(seed)
    if not region.PointInSet(centre):
        raise ArgumentError(f'domain does not hold the state {centre.tolist()}')
    for number in range(1, most_rounds + 1):
        error = 6.0 * (1.0 - confidence) / (math.pi * number) ** 2
        count = math.ceil(math.log(error) / math.log1p(-collision_fraction))
        samples = region.UniformSamples(rng, centre, count)
        is_free = checker.free_each(samples)
        if is_free.all():
            return FreeRegion(region, certificate, collision_fraction, confidence)
        region = _cut(checker, region, centre, samples[~is_free], samples.std(axis=0))
    raise GeometryError(
        f'after {most_rounds} rounds samples still collide; nothing is known of the region. Raise '
        f'most_rounds or collision_fraction={collision_fraction}'
    )


def _domain(checker: Checker, domain: HPolyhedron | None) -> HPolyhedron:
    """Return a domain of the joints, by default their limits; raises ArgumentError for others."""
    joints = checker.joints
    if domain is None:
        unlimited = np.flatnonzero(~np.isfinite(joints.upper - joints.lower)).tolist()
        if unlimited:
            names = ', '.join(joints.names[k] for k in unlimited)
            raise ArgumentError(
                f'{names} have no limits, and a probabilistic region is sampled evenly: pass a '
                'bounded domain, such as HPolyhedron.MakeBox(q - 3, q + 3)'
            )
        return HPolyhedron.MakeBox(joints.lower, joints.upper)
    if not isinstance(domain, HPolyhedron) or domain.ambient_dimension() != joints.count:
        raise ArgumentError(
            f'domain={domain!r} must be an HPolyhedron of {joints.count} dimensions'
        )
    return domain


def _cut(
    checker: Checker, region: HPolyhedron, centre: Floats, collisions: Floats, spread: Floats
) -> HPolyhedron:
    """Return a region without collisions (k, c), each cut off by a plane that faces the centre.

    A plane goes halfway between the last state that was free on the way from the centre and the
    first one that was not. It is tangent to the obstacle, normal to the gradient of the clearance,
    or normal to the way where that is steep against it, in joint values by their ``spread`` (c,).
    (Tangent planes left 1.3 to 45 times the volume of planes normal to the way, for five states.)
    """
    free, hit = np.tile(centre, (len(collisions), 1)), collisions.copy()
    for _ in range(_HALVINGS):
        middle = 0.5 * (free + hit)
        is_free = checker.free_each(middle)
        free[is_free], hit[~is_free] = middle[is_free], middle[~is_free]
    edges, ways = 0.5 * (free + hit), hit - centre
    normals = -checker.clearance_and_gradient(edges).gradient
    aside = np.einsum('ki,ki->k', normals, ways) <= _FACING * np.linalg.norm(
        normals * spread, axis=1
    ) * np.linalg.norm(ways / spread, axis=1)
    normals[aside] = ways[aside] / spread**2
    order = np.argsort(np.linalg.norm((hit - centre) / spread, axis=1), kind='stable')
    A: list[Floats] = []
    b: list[float] = []
    left = collisions[order]
    edges, normals = edges[order], normals[order]
    while len(left) and len(A) < _MOST_PLANES:
        A.append(normals[0])
        b.append(float(normals[0] @ edges[0]))
        keep = left @ normals[0] <= b[-1]
        keep[0] = False  # rounding must not leave the collision itself
        left, edges, normals = left[keep], edges[keep], normals[keep]
    return region.Intersection(HPolyhedron(np.array(A), np.array(b)))


def _slack(checker: Checker, q: ArrayLike, margin: float | None) -> Floats:
    """Return how far (k,) [m] each pair is certified to be beyond the margin."""
    limit = checker.margin if margin is None else as_number(margin)
    if limit is None or not 0.0 <= limit < math.inf:
        raise ArgumentError(f'margin={margin!r} must be a number >= 0, in metres')
    answer = checker.distances_and_gradients(q)
    if answer.distance.ndim != 1:
        count = checker.joints.count
        raise ArgumentError(f'q has the shape {np.shape(q)}; it must be ({count},), one state')
    state, joints = np.asarray(q, dtype=np.float64), checker.joints
    beyond = np.flatnonzero((state < joints.lower) | (state > joints.upper)).tolist()
    if beyond:
        k = beyond[0]
        raise ArgumentError(
            f'{joints.names[k]} = {state[k]:.6g} is outside its limits [{joints.lower[k]:.6g}, '
            f'{joints.upper[k]:.6g}], within which the proof holds'
        )
    return answer.lower_bound - limit


def _rounded_down(value: float) -> float:
    """Return a number below by more than the rounding of sums over joints."""
    return float(value * (1.0 - 2.0**-40))
