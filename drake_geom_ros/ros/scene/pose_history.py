"""Where frames were: the poses of the last seconds, for what is taken at a stamp. No ROS import.

Between two poses of a frame the position goes straight and the orientation by the shorter arc;
beyond the last one, and across a long gap, nobody knows.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.ros.scene.clocks import ALWAYS
from drake_geom_ros.ros.scene.pose_ages import PosedFrames
from drake_geom_ros.trajectories.timed_poses import slerp

KEPT = 3.0  # [s] by the node's time
LONGEST_GAP = 0.5  # [s] between two poses, across which one is told
_MOST = 100_000  # messages: what comes faster is kept for less long

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class _Entry(NamedTuple):
    """The poses of one message that hold since the same time."""

    epoch: float
    held: float  # [s] of the node's time
    frames: frozenset[int]
    ids: Indices  # (n,) of all frames of the message
    rows: Floats  # (n, 7)


class PosesThen(NamedTuple):
    """What is known of a time: poses X_PF (n, 7) of frames (n,), and why not of others."""

    ids: Indices
    rows: Floats
    later: frozenset[int]  # frames whose newest pose is of before: it may still come
    lost: frozenset[int]  # frames of whose pose then nothing will be known


class PoseHistory:
    """Keeps what came for frames that move, by id values."""

    def __init__(self) -> None:
        self._entries: deque[_Entry] = deque(maxlen=_MOST)

    def note(self, ids: Indices, rows: Floats, posed: PosedFrames) -> None:
        """Keep the poses (n, 7) of frames (n,) that hold since the times of ``posed``."""
        rows = rows.copy()  # senders' arrays are filled anew
        for frames, since in posed.items():
            if since == ALWAYS:
                continue
            entries = self._entries
            if entries and entries[-1].epoch != since.epoch:
                entries.clear()  # the node's time jumped: what was is of another time
            entries.append(_Entry(since.epoch, since.held, frames, ids, rows))
            while entries[0].held < since.held - KEPT:
                entries.popleft()

    def begins_before(self, time: float) -> bool:
        """Return whether anything is known of before a time [s]."""
        return any(entry.held <= time for entry in self._entries)

    def at(self, time: float, wanted: Collection[int]) -> PosesThen:
        """Return the poses of wanted frames at a time [s]."""
        before: dict[int, _Entry] = {}
        after: dict[int, _Entry] = {}
        known = set(wanted)
        for entry in self._entries:
            for frame in entry.frames & known:
                if entry.held <= time:
                    if frame not in before or before[frame].held <= entry.held:
                        before[frame] = entry
                elif frame not in after or after[frame].held > entry.held:
                    after[frame] = entry
        found, lost, later = list[int](), set[int](), set[int]()
        for frame in known:
            first, last = before.get(frame), after.get(frame)
            if first is not None and first.held == time:
                after[frame] = first
            elif first is not None and last is None:
                later.add(frame)
                continue
            elif first is None or last is None or last.held - first.held > LONGEST_GAP:
                lost.add(frame)
                continue
            found.append(frame)
        found.sort()
        rows = np.array(
            [_between(f, before[f], after[f], time) for f in found], dtype=np.float64
        ).reshape(-1, 7)
        return PosesThen(np.array(found, dtype=np.int64), rows, frozenset(later), frozenset(lost))


def _between(frame: int, first: _Entry, last: _Entry, time: float) -> Floats:
    a, b = (entry.rows[np.flatnonzero(entry.ids == frame)[-1]] for entry in (first, last))
    if first.held == last.held:
        return np.array(a)
    share = (time - first.held) / (last.held - first.held)
    q0, q1 = a[3:], b[3:] if a[3:] @ b[3:] >= 0.0 else -b[3:]
    turned = slerp(q0, q1, np.array([share]))
    return np.concatenate([a[:3] + share * (b[:3] - a[:3]), turned])
