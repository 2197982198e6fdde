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
from collections.abc import Sequence
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

    def times_at(self, share: float) -> Floats:
        """Return the times (c,) to brake from a share."""
        shares = self.shares
        k = min(int(np.searchsorted(shares, share, 'right')), len(shares) - 1) - 1
        part = (share - shares[k]) / (shares[k + 1] - shares[k])
        return np.asarray(self.times[k] + part * (self.times[k + 1] - self.times[k]))

    def duration_at(self, share: float) -> float:
        """Return the time [s] from now until all columns stand."""
        moves = self.velocities != 0.0
        return float((self.reactions + self.times_at(share))[moves].max(initial=0.0))

    def travel(self, share: float = 1.0) -> Floats:
        """Return how far (c,) [rad] or [m] columns go from their values, with their sign."""
        on = self.reactions + 0.5 * self.times_at(share)
        return np.asarray(self.velocities * (self.ages + share * on))


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
    shares, edges = profile.shares, []
    times = [profile.duration_at(share) for share in shares.tolist()]
    start = values + profile.velocities * profile.ages
    if profile.ages.any():  # of the past, by now: those who approach have the reaction time
        none = np.zeros_like(values)
        edges.append(_Edge(values, start - values, none, profile.radii))
        shares, times = np.append(0.0, shares), [times[0], *times]
    for k in range(len(profile.shares) - 1):
        (s0, s1), (T0, T1) = profile.shares[k : k + 2].tolist(), profile.times[k : k + 2]
        edge = _edge_of(start, profile, (s0, s1), (T0, T1))
        edges.append(edge._replace(radius=profile.radii))
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
    even = np.linspace(first, last, parts + 1)
    shares = np.unique(np.concatenate((profile.shares[inside], even)))
    times = [profile.duration_at(share) for share in shares.tolist()]
    begun = profile.velocities * profile.ages
    edges = []
    for s0, s1 in zip(shares[:-1].tolist(), shares[1:].tolist(), strict=True):
        T0, T1 = profile.times_at(s0), profile.times_at(s1)
        edge = _edge_of(begun, profile, (s0, s1), (T0, T1))
        radius = 0.5 * np.abs(edge.end()) + profile.radii
        edges.append(_Edge(values + 0.5 * edge.start, 0.5 * edge.first, 0.5 * edge.second, radius))
    return StopPath(_path(edges, times), shares)


def path_over_time(values: Floats, profile: StopProfile) -> StopPath:
    """Return the path of the stop from the whole present speed, over time [s] from now on.

    All columns that move have one reaction time and one time to brake.
    """
    moves = profile.velocities != 0.0
    reaction = float(profile.reactions[moves].max(initial=0.0))
    braking = profile.duration_at(1.0) - reaction
    none, v, radii = np.zeros_like(values), profile.velocities, profile.radii
    now = values + v * profile.ages
    edges, times = [], [0.0]
    if profile.ages.any():
        edges.append(_Edge(values, now - values, none, radii))
        times.append(0.0)
    if reaction > 0.0:
        edges.append(_Edge(now, v * reaction, none, radii))
        times.append(reaction)
    edges.append(_Edge(now + v * reaction, v * braking, -0.5 * v * braking, radii))
    times.append(reaction + braking)
    return StopPath(_path(edges, times), np.array(times))


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
    shares = np.unique(np.concatenate((profile.shares, other.shares)))
    shares = shares[shares <= min(profile.fastest, other.fastest)]
    times = [
        np.where(is_other, other.times_at(share), profile.times_at(share))
        for share in shares.tolist()
    ]
    each = zip(other[:3], profile[:3], strict=True)
    velocities, ages, reactions = (np.where(is_other, theirs, own) for theirs, own in each)
    radii = np.where(is_other, other.radii, profile.radii)
    return StopProfile(velocities, ages, reactions, shares, np.array(times), radii)


def standing(count: int) -> StopProfile:
    """Return the profile of columns none of which moves."""
    none = np.zeros(count)
    return StopProfile(none, none, none, np.array([0.0, 1.0]), np.zeros((2, count)), none)


class _Edge(NamedTuple):
    """Values ``start + s first + s^2 second`` (c,) for s from 0 to 1, within a radius."""

    start: Floats
    first: Floats
    second: Floats
    radius: Floats | float = 0.0  # (c,)

    def end(self) -> Floats:
        return np.asarray(self.start + self.first + self.second)


def _edge_of(
    start: Floats,
    profile: StopProfile,
    shares: tuple[float, float],
    times: tuple[Floats, Floats],
) -> _Edge:
    """Return the edge ``start + v p(s)`` between two shares, where times are linear."""
    v, (s0, s1), (T0, T1) = profile.velocities, shares, times
    width, longer = s1 - s0, T1 - T0
    on = profile.reactions + 0.5 * T0
    return _Edge(
        start + v * (s0 * on),
        v * (width * on + 0.5 * s0 * longer),
        v * (0.5 * width * longer),
    )


def _path(edges: Sequence[_Edge], times: Sequence[float]) -> JointPath:
    """Return the path along edges, with the bounds of each one's derivatives and values."""
    rows = np.array([*(edge.start for edge in edges), edges[-1].end()])
    curves = np.zeros((len(edges), 9, rows.shape[1]))
    for k, edge in enumerate(edges):
        first, second, radius = edge.first, edge.second, edge.radius
        size = np.maximum(np.abs(edge.start), np.abs(edge.start + first + second))
        # No value turns back on its way, so that its ends bound it.
        magnitude = np.abs(edge.start) + np.abs(first) + np.abs(second)
        curves[k, 0], curves[k, 1] = first, second
        curves[k, 5] = np.maximum(np.abs(first), np.abs(first + 2.0 * second))
        curves[k, 6] = 2.0 * np.abs(second)
        curves[k, 7] = size + radius
        # A box around the path counts as rounding does: its values may be that far off.
        curves[k, 8] = radius + SPLINE_ROUNDING * (magnitude + radius)
    return JointPath(rows, curves, np.array(times, dtype=np.float64))
