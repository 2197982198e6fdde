"""Closing speeds of pairs, from query results and the twists of frames."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model._records import WORLD_FRAME_ID
from drake_geom_ros.geometry.queries.query_results import PenetrationResults, SignedDistanceResults
from drake_geom_ros.math.array_types import Floats


class ClosingSpeeds(NamedTuple):
    """Closing speeds of k pairs, and the times to contact if the speeds stayed constant.

    Both are NaN where ``known`` is False: the frame of A or that of B has no twist. The time to
    contact is infinite for a pair that does not close, and 0 for one in contact. Where the nearest
    points are not unique (``is_gradient_unique``) the speed is that of the reported ones.
    """

    known: NDArray[np.bool_]  # (k,)
    speed: Floats  # (k,) [m/s], positive where bodies come together, or deeper into each other
    time_to_contact: Floats  # (k,) [s]


def closing_speeds(
    results: SignedDistanceResults | PenetrationResults, V_WFs: Mapping[FrameId, ArrayLike]
) -> ClosingSpeeds:
    """Return the closing speeds of pairs, of overlaps too, at the spatial velocities of frames.

    ``V_WFs`` maps frames to V_WF = [w_WF, v_WFo] (6,), in World axes [rad/s, m/s]. The world frame
    need not be in it; pairs of any other frame that is missing get NaN. Raises ArgumentError for a
    twist that is not six finite numbers.
    """
    values = {WORLD_FRAME_ID.get_value(): np.zeros(6)}
    for frame, V in V_WFs.items():
        twist = np.asarray(V, dtype=float)
        if twist.shape != (6,) or not np.isfinite(twist).all():
            raise ArgumentError(
                f'closing_speeds: the twist of {frame!r} is {twist.tolist()}; it must be six '
                'finite numbers, wx wy wz [rad/s] vx vy vz [m/s].'
            )
        values[frame.get_value()] = twist
    ids = np.array(sorted(values), dtype=np.int64)
    twists = np.stack([values[int(id)] for id in ids])
    at, has_twists = [], np.ones(len(results), dtype=np.bool_)
    for frames in (results.frame_id_A, results.frame_id_B):
        at.append(np.searchsorted(ids, frames).clip(max=len(ids) - 1))
        has_twists &= ids[at[-1]] == frames
    V = np.hstack((twists[at[0]], twists[at[1]]))
    if isinstance(results, PenetrationResults):
        growing, distance = results.gradients, -results.depth
    else:
        growing, distance = -results.gradients, results.distance
    speed = np.where(has_twists, np.einsum('ki,ki->k', growing, V), np.nan)
    return ClosingSpeeds(has_twists, speed, _times_to_contact(distance, speed))


def _times_to_contact(distance: Floats, speed: Floats) -> Floats:
    """Return distance over speed for closing pairs, 0 for contacts, NaN for unknown speeds."""
    times = np.full(len(distance), np.inf)
    closing = speed > 0.0
    np.divide(distance, speed, out=times, where=closing)
    times[distance <= 0.0] = 0.0
    times[np.isnan(speed)] = np.nan
    return times
