"""Point kernel of maps: each point is a ball of radius 0."""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    UNIQUE,
    WITNESS_B,
    Aim,
    OrientedShape,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    PointAnswers,
    PointedBody,
    Span,
    put_point,
    seen,
)
from drake_geom_ros.geometry._proximity.kernels.sensed.bodies import map_pair, moved_away
from drake_geom_ros.geometry._proximity.kernels.sensed.pairs import answer_of
from drake_geom_ros.geometry._proximity.kernels.vectors import norm, sub, unrotate, vector_at
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, SPHERE
from drake_geom_ros.geometry._proximity.runtime.addresses import Address
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating


@allocating
def to_map(
    address: Address,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points to a map; ``address`` is a ball and cell kernel's."""
    point = OrientedShape(SPHERE, np.zeros(1), np.eye(3))
    G, aim = OrientedShape(kind, body.shape, body.R_WG), Aim(0.0, 0.0, threshold, 0.0)
    pair, out = map_pair(address, point, G, aim, 0.0), np.zeros(PAIR_WIDTH)
    for k in range(span.first, span.last):
        near, _, rounding = seen(body, p_WQs, k, threshold)
        if not near:
            continue
        p = sub(vector_at(body.p_WG, 0), vector_at(p_WQs[k], 0))
        answer_of(moved_away(pair, norm(p)), p, threshold + rounding, out)
        bound = out[ERROR_BOUND] + rounding
        if out[METHOD] == BOUND_ONLY or out[DISTANCE] - bound > threshold:
            continue
        # The witness on G is measured from the point.
        p_GN = unrotate(body.R_WG, sub(vector_at(out, WITNESS_B), p))
        grad_W, unique = vector_at(out, NORMAL), out[UNIQUE] > 0.0
        at = k * span.n + span.g
        put_point(answers.rows, at, out[DISTANCE], grad_W, p_GN, bound, unique, out[METHOD])
        answers.is_within[at] = True
        answers.counts[int(out[METHOD])] += 1
