"""Questions about stops, and their answers."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.stopping.braking import Braking

RESOLUTION = 0.02  # [-] of the scale
_NOWHERE = np.full(3, np.nan)


@dataclass(frozen=True, eq=False)
class StoppingQuestion:
    """Bodies that brake, and those that they must not meet.

    Args:
        braking: Which joints brake, and how. Its ``joint_names`` are of robots with a link in
            ``set_a``.
        set_a: Id values (n,) of the geometries that brake.
        set_b: Id values of those that they are held against; None: all others.
        margin: All pairs must stay farther apart than this [m].
        max_speed: Of everything in the pairs that neither brakes nor stands [m/s].
    """

    braking: Braking
    set_a: Collection[int]
    set_b: Collection[int] | None = None
    margin: float = 0.0
    max_speed: float = 0.0

    def __post_init__(self) -> None:
        for field in ('margin', 'max_speed'):
            value = getattr(self, field)
            if not (math.isfinite(value) and value >= 0.0):
                raise ArgumentError(f'{field}={value!r} must be finite and >= 0')


class Stop(NamedTuple):
    """Answer to one ``StoppingQuestion``.

    ``scale`` is the largest share of the present speed such that braking from it, and from every
    smaller one, is proved to keep all pairs farther apart than ``margin``. The scale 0 promises
    that the robot stands, and nothing about others. ``clear`` is about braking from the present
    speed alone. Where the answer is not clear, the pair is the one that could not be proved.
    """

    clear: bool
    scale: float
    stopping_time: float = 0.0  # [s] from now until all stand, from the present speed
    stopping_distance: float = 0.0  # [m] certified: no point of set_a goes farther
    linear: float = 0.0  # [m/s] certified: no point of set_a is faster at the scale
    angular: float = 0.0  # [rad/s] no joint that brakes, and no base, turns faster at the scale
    id_A: int = 0  # 0: no pair
    id_B: int = 0
    distance: float = math.inf  # [m] of the pair, where it comes too near, or nearest
    error_bound: float = 0.0  # [m]
    p_WCa: Floats = _NOWHERE  # (3,) [m]
    p_WCb: Floats = _NOWHERE
    least_clearance: float = math.inf  # [m] certified on the way; -inf where it is not clear
    contact_time: float = math.inf  # [s] from now on: until then all is proved
    reaction_time: float = 0.0  # [s] that was assumed: of the braking, delay and age together
    oldest_pose_age: float = 0.0  # [s] of the bodies that it is about
    pairs: int = 0  # that were looked at
    far_pairs: int = 0  # that cannot meet within the stopping time, by their boxes
    far_bodies: int = 0  # of those that it is about, in no pair that was looked at
    idle_joints: int = 0  # columns that brake and move no pair that was looked at
    evaluations: int = 0
    trouble: str = ''  # why nothing is proved; empty: it was looked at


FREE = Stop(True, 1.0)  # of no pair at all


def unproved(trouble: str) -> Stop:
    """Return the answer where nothing is proved."""
    return Stop(
        *(False, 0.0, math.inf, math.inf),
        least_clearance=-math.inf,
        contact_time=0.0,
        trouble=trouble,
    )


def worse(stop: Stop, other: Stop) -> Stop:
    """Return the answer about the pairs of two answers together: that with the smaller scale."""
    if stop is FREE:
        return other
    first, second = sorted((stop, other), key=_goodness)
    return first._replace(
        clear=stop.clear and other.clear,
        least_clearance=min(stop.least_clearance, other.least_clearance),
        contact_time=min(stop.contact_time, other.contact_time),
        pairs=stop.pairs + other.pairs,
        far_pairs=stop.far_pairs + other.far_pairs,
        far_bodies=stop.far_bodies + other.far_bodies,
        idle_joints=stop.idle_joints + other.idle_joints,
        evaluations=stop.evaluations + other.evaluations,
        trouble=first.trouble or second.trouble,
    )


def _goodness(stop: Stop) -> tuple[float, float, float]:
    return stop.scale, stop.least_clearance, stop.distance
