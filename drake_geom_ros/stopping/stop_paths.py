"""Paths in joint space that hold every stop from every share of the present speed.

A stop from the share s of the present velocities v goes on at s v through the reaction time r and
brakes evenly within T(s). It covers ``v p(s)`` with ``p(s) = s (r + T(s) / 2)``, within the time
``r + T(s)``. All stops along a path from shares up to s visit its points up to ``v p(s)``. Each
point is visited latest by the stop that ends there: slower ones do not reach it, faster ones have
passed it. So one path over s, with ``r + T(s)`` as its time, holds all of them: where it is clear
up to s, so is each stop from there or slower, whatever approaches at a bounded speed meanwhile.

Where joints stop each by itself, or robots stop independently, joint j may be anywhere between
its value now and ``v_j p_j(s)``. That box is held by its middle and half its size.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.queries.motion_queries import JointPath
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import SPLINE_ROUNDING

_BOXES = 4  # edges of a path of boxes: on each one the largest of its boxes counts


class StopProfile(NamedTuple):
    """Times [s] that columns (c,) take to brake, by the share of their present speed.

    They are linear between ``shares`` (k,), which ascend from 0; above the last one nothing is
    known. Columns that do not brake have the time 0.
    """

    velocities: Floats  # (c,) 0: the column stands
    ages: Floats  # (c,) [s] for which a column already went on at its velocity
    reactions: Floats  # (c,) [s] for which it will go on at it
    shares: Floats  # (k,)
    times: Floats  # (k, c) [s]
    radii: Floats  # (c,) by which values may deviate from their path

    @property
    def fastest(self) -> float:
        """The largest share that is known."""
        return float(self.shares[-1])

    def times_at(self, share: float | Floats) -> Floats:
        """Return the times (c,) to brake from a share, or (s, c) from shares (s,)."""
        shares = self.shares
        k = np.minimum(np.searchsorted(shares, share, 'right'), len(shares) - 1) - 1
        part = np.asarray((share - shares[k]) / (shares[k + 1] - shares[k]))[..., np.newaxis]
        return np.asarray(self.times[k] + part * (self.times[k + 1] - self.times[k]))

    def duration_at(self, share: float) -> float:
        """Return the time [s] from now until all columns stand."""
        return float(self.durations(self.times_at(share)))

    def durations(self, times: Floats) -> Floats:
        """Return the time (...,) [s] from now until all columns stand that brake for (..., c)."""
        moves = self.velocities != 0.0
        return np.asarray((self.reactions + times)[..., moves].max(axis=-1, initial=0.0))

    def travel(self, share: float = 1.0) -> Floats:
        """Return how far (c,) [rad] or [m] columns go from their values, with their sign."""
        on = self.reactions + 0.5 * self.times_at(share)
        return np.asarray(self.velocities * (self.ages + share * on))

    def until(self, share: float) -> StopProfile:
        """Return the profile of the stops from shares up to one, and some beyond it.

        It ends at a power of 1/2, so that bisections examine the same shares wherever it ends.
        """
        part, exponent = math.frexp(share)
        last = math.ldexp(1.0, exponent - (part == 0.5))
        if last >= self.fastest:
            return self
        known = self.shares < last
        times = np.vstack((self.times[known], self.times_at(last)))
        return self._replace(shares=np.append(self.shares[known], last), times=times)

    def seconds_within(self, share: float) -> float:
        """Return for how long [s] from now on the stop of now is where those up to a share go.

        It is faster than these, so whatever approaches meanwhile has no more time for it.
        """
        moves = self.velocities != 0.0
        r, T = self.reactions[moves], self.times_at(1.0)[moves]
        way = share * (r + 0.5 * self.times_at(share)[moves])  # [s] at the present speed
        left = 1.0 - 2.0 * np.divide(way - r, T, out=np.zeros_like(way), where=way > r)
        seconds = np.where(way > r, r + T * (1.0 - np.sqrt(left.clip(0.0))), way)
        return float(seconds.min(initial=math.inf))


class StopPath(NamedTuple):
    """A path, with what is reached at each of its rows (k,): a share, or a time [s]."""

    path: JointPath
    reached: Floats

    def edge(self, row: float) -> tuple[float, float]:
        """Return what is reached at both ends of the edge with a row number."""
        edge = min(int(row), len(self.reached) - 2)
        begin, end = self.reached[edge : edge + 2].tolist()
        return begin, end

    def at(self, row: float) -> float:
        """Return what is reached at a row number, rounded down."""
        edge = min(int(row), len(self.reached) - 2)
        begin, end = self.reached[edge : edge + 2].tolist()
        value = begin + (end - begin) * (row - edge)
        return float(max(begin, math.nextafter(value, -math.inf)) if row > edge else begin)


def path_over_shares(values: Floats, profile: StopProfile) -> StopPath:
    """Return the path of all stops along the path from ``values`` (c,), over the share."""
    shares, times = profile.shares, profile.durations(profile.times)
    begun = profile.velocities * profile.ages
    edges = _edges_of(values + begun, profile, shares, profile.times)
    if profile.ages.any():  # of the past, by now: those who approach have the reaction time
        edges = _Edges.one(values, begun, 0.0 * begun, profile.radii).then(edges)
        shares, times = np.append(0.0, shares), np.append(times[0], times)
    return StopPath(_path(edges, times), shares)


def boxes_over_shares(
    values: Floats,
    profile: StopProfile,
    span: tuple[float, float] | None = None,
    parts: int = _BOXES,
) -> StopPath:
    """Return the path of the boxes of all stops of each column by itself, over the share.

    It goes over a ``span`` of shares, in so many ``parts``; None: over all.
    """
    first, last = span or (0.0, profile.fastest)
    inside = (profile.shares > first) & (profile.shares < last)
    shares: Floats = first + (last - first) * np.arange(parts + 1.0) / parts
    if inside.any():
        shares = np.unique(np.concatenate((profile.shares[inside], shares)))
    times = profile.times_at(shares)
    edges = _edges_of(profile.velocities * profile.ages, profile, shares, times)
    boxes = _Edges(
        values + 0.5 * edges.start,
        0.5 * edges.first,
        0.5 * edges.second,
        0.5 * np.abs(edges.end()) + profile.radii,
    )
    return StopPath(_path(boxes, profile.durations(times)), shares)


def path_over_time(values: Floats, profile: StopProfile) -> StopPath:
    """Return the path of the stop from the whole present speed, over time [s] from now on.

    All columns that move have one reaction time and one time to brake.
    """
    moves = profile.velocities != 0.0
    reaction = float(profile.reactions[moves].max(initial=0.0))
    braking = profile.duration_at(1.0) - reaction
    v, radii = profile.velocities, profile.radii
    now, none = values + v * profile.ages, np.zeros_like(values)
    edges = _Edges.one(now + v * reaction, v * braking, -0.5 * v * braking, radii)
    times = [reaction, reaction + braking]
    if reaction > 0.0:
        edges = _Edges.one(now, v * reaction, none, radii).then(edges)
        times.insert(0, 0.0)
    if profile.ages.any():
        edges = _Edges.one(values, now - values, none, radii).then(edges)
        times.insert(0, 0.0)
    return StopPath(_path(edges, np.array(times)), np.array(times))


def end_of_stops(values: Floats, profile: StopProfile) -> StopPath:
    """Return the path that rests where the stop from the whole present speed ends, by then."""
    row = values + profile.travel(1.0)
    times = np.full(2, profile.duration_at(1.0))
    path = JointPath.straight(np.stack((row, row)))
    return StopPath(path._replace(times=times), times)


def unit_path(sizes: Floats) -> JointPath:
    """Return a path with an edge for each column (c,), on which that one moves at the rate 1.

    Values are no larger than ``sizes`` (c,) on it.
    """
    count = len(sizes)
    curves = np.zeros((count, 9, count))
    curves[:, 5] = np.eye(count)
    curves[:, 7] = sizes
    return JointPath(np.zeros((count + 1, count)), curves, np.arange(count + 1.0))


def joined(profile: StopProfile, other: StopProfile) -> StopProfile:
    """Return the profile of the columns that move in one of two profiles, each by its own."""
    is_other = other.velocities != 0.0
    shares = profile.shares
    if not np.array_equal(shares, other.shares):
        shares = np.unique(np.concatenate((shares, other.shares)))
        shares = shares[shares <= min(profile.fastest, other.fastest)]
    times = np.where(is_other, other.times_at(shares), profile.times_at(shares))
    each = zip(other[:3], profile[:3], strict=True)
    velocities, ages, reactions = (np.where(is_other, theirs, own) for theirs, own in each)
    radii = np.where(is_other, other.radii, profile.radii)
    return StopProfile(velocities, ages, reactions, shares, times, radii)


class _Edges(NamedTuple):
    """Values ``start + s first + s^2 second`` (e, c) for s from 0 to 1, within a radius."""

    start: Floats
    first: Floats
    second: Floats
    radius: Floats

    @classmethod
    def one(cls, start: Floats, first: Floats, second: Floats, radius: Floats) -> _Edges:
        """Return a single edge of values (c,)."""
        return cls(start[None], first[None], second[None], radius[None])

    def then(self, others: _Edges) -> _Edges:
        """Return these edges and others behind them."""
        return _Edges(*(np.concatenate(both) for both in zip(self, others, strict=True)))

    def end(self) -> Floats:
        return np.asarray(self.start + self.first + self.second)


def _edges_of(start: Floats, profile: StopProfile, shares: Floats, times: Floats) -> _Edges:
    """Return the edges ``start + v p(s)`` between shares (s,), where times (s, c) are linear."""
    v, s0 = profile.velocities, shares[:-1, None]
    width, longer = shares[1:, None] - s0, times[1:] - times[:-1]
    on = profile.reactions + 0.5 * times[:-1]
    return _Edges(
        start + v * (s0 * on),
        v * (width * on + 0.5 * s0 * longer),
        v * (0.5 * width * longer),
        0.0 * longer + profile.radii,
    )


def _path(edges: _Edges, times: Floats) -> JointPath:
    """Return the path along edges, with the bounds of each one's derivatives and values."""
    start, first, second, radius = edges
    speed, bend = np.abs(first), np.abs(second)
    curves = np.zeros((len(start), 9, start.shape[1]))
    curves[:, 0], curves[:, 1] = first, second
    curves[:, 5] = np.maximum(speed, np.abs(first + 2.0 * second))
    curves[:, 6] = 2.0 * bend
    # No value turns back on its way, so that its ends bound it.
    size, end = np.abs(start), edges.end()
    curves[:, 7] = np.maximum(size, np.abs(end)) + radius
    # A box around the path counts as rounding does: its values may be that far off.
    curves[:, 8] = radius + SPLINE_ROUNDING * (size + speed + bend + radius)
    return JointPath(np.concatenate((start, end[-1:])), curves, times)
