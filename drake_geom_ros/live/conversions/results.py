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
from drake_geom_ros.live.conversions.fields import fill_arrays, floats, uint8s, uint32s, unsigned

# What a row of each takes in a message [bytes].
PENETRATION_SIZE = 105
SIGNED_DISTANCE_SIZE = 106
POINT_DISTANCE_SIZE = 78
CANDIDATE_SIZE = 16
# The arrays that messages bear, under the same names in lower case.
_OF_PAIRS = ('id_A', 'id_B', 'nhat_BA_W', 'error_bound', 'method')
_OF_PENETRATIONS = (*_OF_PAIRS, 'p_WCa', 'p_WCb', 'depth')
_OF_DISTANCES = (*_OF_PAIRS, 'p_ACa', 'p_BCb', 'distance', 'is_nhat_BA_W_unique')


def fill_penetrations(message: Any, results: PenetrationResults) -> None:
    """Fill the arrays of a PenetrationPairs message."""
    fill_arrays(message, _arrays(results, _OF_PENETRATIONS))


def fill_signed_distances(
    message: Any, results: SignedDistanceResults, max_distance: float
) -> None:
    """Fill the arrays of a SignedDistancePairs message."""
    message.max_distance = max_distance
    fill_arrays(message, _arrays(results, _OF_DISTANCES))


def _arrays(
    results: PenetrationResults | SignedDistanceResults, names: tuple[str, ...]
) -> dict[str, NDArray[Any]]:
    """Return arrays of results by the names of fields, which are the same in lower case."""
    return {name.lower(): getattr(results, name) for name in names}


def fill_closing_speeds(message: Any, speeds: ClosingSpeeds | None) -> None:
    """Fill the closing speeds of a message of pairs; leave them empty where nobody watches."""
    if speeds is None:
        return
    arrays = {
        'has_closing_speed': speeds.known,
        'closing_speed': speeds.speed,
        'time_to_contact': speeds.time_to_contact,
    }
    fill_arrays(message, arrays)


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
