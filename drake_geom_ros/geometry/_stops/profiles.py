"""Times to brake by the share of the present speed, and what follows from them."""

from __future__ import annotations

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._stops.compiled import compiled, inlined

# Rows of ``ProfileArrays.columns``, of a column of joint values: its velocity; for how long [s] it
# already went on at it since its value was measured, and will go on at it; and by how much its
# values may deviate from their path.
VELOCITY, AGE, REACTION, RADIUS = 0, 1, 2, 3
PROFILE_ROWS = 4


class ProfileArrays(NamedTuple):
    """Times [s] that columns take to brake, linear between shares of their present speed."""

    columns: Floats  # (PROFILE_ROWS, c)
    shares: Floats  # (k,) ascending from 0
    times: Floats  # (k, c)


@inlined
def time_at(profile: ProfileArrays, share: float, c: int) -> float:
    """Return the time [s] that a column takes to brake from a share."""
    shares, times, k = profile.shares, profile.times, 0
    while k + 2 < shares.size and shares[k + 1] <= share:
        k += 1
    part = (share - shares[k]) / (shares[k + 1] - shares[k])
    time: float = times[k, c] + part * (times[k + 1, c] - times[k, c])
    return time


@inlined
def duration_at(profile: ProfileArrays, share: float) -> float:
    """Return the time [s] from now until all columns stand."""
    columns, seconds = profile.columns, 0.0
    for c in range(columns.shape[1]):
        if columns[VELOCITY, c] != 0.0:
            seconds = max(seconds, columns[REACTION, c] + time_at(profile, share, c))
    return seconds


@inlined
def reaction_of(profile: ProfileArrays) -> float:
    """Return the longest time [s] for which a column that moves goes on."""
    columns, seconds = profile.columns, 0.0
    for c in range(columns.shape[1]):
        if columns[VELOCITY, c] != 0.0:
            seconds = max(seconds, columns[REACTION, c])
    return seconds


@compiled
def seconds_within(columns: Floats, shares: Floats, times: Floats, share: float) -> float:
    """Return for how long [s] from now on the stop of now is where those up to a share go.

    It is faster than these, so whatever approaches meanwhile has no more time for it.
    """
    profile, least = ProfileArrays(columns, shares, times), math.inf
    for c in range(columns.shape[1]):
        if columns[VELOCITY, c] == 0.0:
            continue
        reaction, braking = columns[REACTION, c], time_at(profile, 1.0, c)
        seconds = share * (reaction + 0.5 * time_at(profile, share, c))  # at the present speed
        if seconds > reaction:
            left = max(0.0, 1.0 - 2.0 * (seconds - reaction) / braking)
            seconds = reaction + braking * (1.0 - math.sqrt(left))
        least = min(least, seconds)
    return least
