"""Things beside bodies that are no geometry: their distance now is all that is known of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.stopping.stop import RESOLUTION, Stop

_UNSEEN = (
    'a body that brakes is out of the sight of all sensors of the maps that the rule is about: '
    'what is near it is unknown'
)
_NOWHERE = np.full(3, np.nan)


class Unmapped(NamedTuple):
    """Something beside a body, by their distance in the pose of now.

    It may approach as the geometry does that stands for it: a sensed map, which lacks what sensors
    saw beside bodies, and what is beyond their reach.
    """

    body: int  # id value of a geometry
    other: int  # id value of the geometry that stands for the thing
    distance: float = -math.inf  # [m]; -inf: unknown, since no sensor sees the body
    error_bound: float = 0.0  # [m]
    p_WCa: Floats = _NOWHERE  # (3,) [m] nearest point on that of the two with the smaller id
    p_WCb: Floats = _NOWHERE

    @property
    def lowest(self) -> float:
        """Certified lower bound [m] of the distance."""
        return self.distance - self.error_bound


def stop_before(
    it: Unmapped, needed: Callable[[float], float], margin: float, fastest: float
) -> Stop:
    """Return the answer about a body that brakes before it meets what is beside it.

    ``needed`` returns the distance [m] of now that a stop from a share of the present speed needs,
    with the ``margin`` [m]; it grows with the share. Above the share ``fastest`` nothing is known.
    """
    id_A, id_B = sorted((it.body, it.other))
    stop = Stop(
        clear=False,
        scale=0.0,
        id_A=id_A,
        id_B=id_B,
        distance=it.distance,
        error_bound=it.error_bound,
        p_WCa=it.p_WCa,
        p_WCb=it.p_WCb,
        least_clearance=-math.inf,
        contact_time=0.0,
        pairs=1,
        trouble='' if it.distance > -math.inf else _UNSEEN,
    )
    left = it.lowest - needed(fastest)
    if left > 0.0:
        return stop._replace(
            clear=fastest >= 1.0,
            scale=fastest,
            least_clearance=left + margin,
            contact_time=math.inf,
        )
    proved, above = 0.0, fastest
    while above - proved > 0.5 * RESOLUTION:
        middle = 0.5 * (proved + above)
        if it.lowest > needed(middle):
            proved = middle
        else:
            above = middle
    return stop._replace(scale=proved)


# Returns for each question what is beside the bodies of its two sets, within a distance [m].
FindUnmapped = Callable[[float], Sequence[Sequence[Unmapped]]]
