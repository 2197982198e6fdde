"""What a report points at: the closest moments, the contacts, the time below thresholds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.recordings.results import Clearances, Moment, SetClearance

Floats = NDArray[np.float64]
_APART = 0.02  # of the duration: in a span of that there is one closest moment at most


class Contact(NamedTuple):
    """States in a row in which the least distance is not certified to be above 0."""

    begin: float  # [s]
    end: float  # [s]
    states: int
    deepest: Moment


class Below(NamedTuple):
    """For how long a distance was not certified to be above a threshold."""

    threshold: float  # [m]
    seconds: float  # of states that tell of all pairs
    at_known: float  # [s] of others, by the pairs and poses that are known


class Held(NamedTuple):
    """How long the states of a set of pairs hold: until the next, at most for so long [s]."""

    whole: float
    stale: float
    waiting: float
    silent: float  # without a state that is new enough


def seconds_held(found: Clearances) -> Floats:
    """Return how long each state holds (N,) [s]: until the next, at most ``stale_after``."""
    ends = np.append(found.times[1:], found.duration)
    return np.clip(ends - found.times, 0.0, found.stale_after)


def held(found: Clearances, pairs: SetClearance) -> Held:
    """Return for how long a set of pairs is known, stale, waiting, and nothing was recorded."""
    seconds = seconds_held(found)
    waiting = pairs.is_waiting
    stale = pairs.is_stale & ~waiting
    whole, old, absent = (float(seconds[f].sum()) for f in (pairs.is_whole, stale, waiting))
    return Held(whole, old, absent, max(0.0, found.duration - whole - old - absent))


def below(found: Clearances, pairs: SetClearance, threshold: float) -> Below:
    """Return for how long [s] the certified lower bound was not above a threshold [m]."""
    near = pairs.known_distance - pairs.known_error_bound <= threshold
    seconds = seconds_held(found)
    whole = pairs.is_whole
    return Below(
        threshold, float(seconds[near & whole].sum()), float(seconds[near & ~whole].sum())
    )


def closest(found: Clearances, pairs: SetClearance, count: int) -> list[int]:
    """Return the states in which the lower bound is least for a while, the least of all first.

    Of states that do not tell all what is known counts, too.
    """
    lower = pairs.known_distance - pairs.known_error_bound
    states = np.flatnonzero(np.isfinite(lower))
    apart = _APART * found.duration or 1.0
    spans = (pairs.times[states] / apart).astype(np.int64)
    order = np.lexsort((lower[states], spans))
    firsts = order[np.flatnonzero(np.diff(spans[order], prepend=-1))]  # the least of each span
    least = np.full(spans.max(initial=0) + 3, np.inf)
    least[spans[firsts] + 1] = lower[states[firsts]]
    here = least[spans[firsts] + 1]
    beside = least[spans[firsts]], least[spans[firsts] + 2]
    chosen = states[firsts[(here <= beside[0]) & (here < beside[1])]]
    return [int(state) for state in chosen[np.argsort(lower[chosen], kind='stable')][:count]]


def contacts(pairs: SetClearance) -> list[Contact]:
    """Return the times in which something is not certified to be apart, by what is known."""
    lower = pairs.known_distance - pairs.known_error_bound
    touching = np.concatenate(([False], lower <= 0.0, [False]))
    begins, ends = (np.flatnonzero(np.diff(touching.astype(np.int8)) == sign) for sign in (1, -1))
    return [
        Contact(
            float(pairs.times[begin]),
            float(pairs.times[end - 1]),
            int(end - begin),
            pairs.at(int(begin + np.argmin(lower[begin:end]))),
        )
        for begin, end in zip(begins, ends, strict=True)
    ]
