"""How fast bodies come together: from results and the twists of frames."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model._records import WORLD_FRAME_ID
from drake_geom_ros.geometry.queries.query_results import PenetrationResults, SignedDistanceResults

Floats = NDArray[np.float64]


class ClosingSpeeds(NamedTuple):
    """Of k pairs: how fast the distance shrinks, and when it would be 0 if that went on.

    Both are NaN where ``known`` is False: the frame of A or that of B has no twist. A pair that
    does not close has an infinite time to contact, one that is in contact 0. Where the nearest
    points are not the only ones (``is_gradient_unique``) the speed is that of the ones reported.
    """

    known: NDArray[np.bool_]  # (k,)
    speed: Floats  # (k,) [m/s], positive where bodies come together, or deeper into each other
    time_to_contact: Floats  # (k,) [s]


def closing_speeds(
    results: SignedDistanceResults | PenetrationResults, V_WFs: Mapping[FrameId, ArrayLike]
) -> ClosingSpeeds:
    """Return the closing speeds of pairs, of overlaps too, at the spatial velocities of frames.

    ``V_WFs`` maps frames to V_WF = [w_WF, v_WFo] (6,), in World axes [rad/s, m/s]; the world frame
    stands still without being named, and pairs with any other that is not named are not known.
    Raises ArgumentError for what is not six finite numbers.
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
    at, known = [], np.ones(len(results), dtype=np.bool_)
    for frames in (results.frame_id_A, results.frame_id_B):
        at.append(np.searchsorted(ids, frames).clip(max=len(ids) - 1))
        known &= ids[at[-1]] == frames
    V = np.hstack((twists[at[0]], twists[at[1]]))
    if isinstance(results, PenetrationResults):
        growing, distance = results.gradients, -results.depth
    else:
        growing, distance = -results.gradients, results.distance
    speed = np.where(known, np.einsum('ki,ki->k', growing, V), np.nan)
    return ClosingSpeeds(known, speed, _times_to_contact(distance, speed))


def _times_to_contact(distance: Floats, speed: Floats) -> Floats:
    """Return distance over speed where it closes, 0 where it has, NaN where nobody knows."""
    times = np.full(len(distance), np.inf)
    closing = speed > 0.0
    np.divide(distance, speed, out=times, where=closing)
    times[distance <= 0.0] = 0.0
    times[np.isnan(speed)] = np.nan
    return times
