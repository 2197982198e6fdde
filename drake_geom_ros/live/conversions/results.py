"""Results of queries to messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ClosingSpeeds,
    PenetrationResults,
    PointDistanceResults,
    SignedDistanceResults,
)
from drake_geom_ros.live.conversions.fields import floats, uint8s, uint32s, unsigned

# What a row of each takes in a message [bytes].
PENETRATION_SIZE = 105
SIGNED_DISTANCE_SIZE = 106
POINT_DISTANCE_SIZE = 78
CANDIDATE_SIZE = 16


def fill_penetrations(message: Any, results: PenetrationResults) -> None:
    """Fill the arrays of a PenetrationPairs message."""
    _fill_pairs(message, results)
    message.p_wca = floats(results.p_WCa)
    message.p_wcb = floats(results.p_WCb)
    message.depth = floats(results.depth)


def fill_signed_distances(
    message: Any, results: SignedDistanceResults, max_distance: float
) -> None:
    """Fill the arrays of a SignedDistancePairs message."""
    _fill_pairs(message, results)
    message.max_distance = max_distance
    message.p_aca = floats(results.p_ACa)
    message.p_bcb = floats(results.p_BCb)
    message.distance = floats(results.distance)
    message.is_nhat_ba_w_unique = results.is_nhat_BA_W_unique.tolist()


def _fill_pairs(message: Any, results: PenetrationResults | SignedDistanceResults) -> None:
    """Fill what all messages of pairs have."""
    message.id_a = unsigned(results.id_A)
    message.id_b = unsigned(results.id_B)
    message.nhat_ba_w = floats(results.nhat_BA_W)
    message.error_bound = floats(results.error_bound)
    message.method = uint8s(results.method)


def fill_closing_speeds(message: Any, speeds: ClosingSpeeds | None) -> None:
    """Fill the closing speeds of a message of pairs; leave them empty where nobody watches."""
    if speeds is None:
        return
    message.has_closing_speed = speeds.known.tolist()
    message.closing_speed = floats(speeds.speed)
    message.time_to_contact = floats(speeds.time_to_contact)


def fill_point_distances(
    message: Any,
    parts: Sequence[PointDistanceResults],
    threshold: float,
    indices: Sequence[NDArray[np.int64]],
) -> None:
    """Fill the arrays of a PointDistances message with the results of blocks of points.

    ``indices[k]`` (m,) are the numbers of block k's points among all points.
    """
    numbers = [index[part.point_index] for part, index in zip(parts, indices, strict=True)]

    def joined(name: str) -> NDArray[Any]:
        return np.concatenate([getattr(part, name) for part in parts])

    message.threshold = threshold
    message.point_index = uint32s(np.concatenate(numbers))
    message.id_g = unsigned(joined('id_G'))
    message.p_gn = floats(joined('p_GN'))
    message.distance = floats(joined('distance'))
    message.grad_w = floats(joined('grad_W'))
    message.is_grad_w_unique = joined('is_grad_W_unique').tolist()
    message.error_bound = floats(joined('error_bound'))
    message.method = uint8s(joined('method'))
