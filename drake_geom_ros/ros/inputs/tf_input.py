"""Frame poses from TF: ``/tf`` and ``/tf_static`` when the parameter ``use_tf`` is set.

A frame of the scene takes the transform of the TF frame that bears its name, ``source/frame`` or,
where only one source has a frame of that name, ``frame``; the chain of TF must lead to the world
frame. Nothing is looked up later: the newest transform of each TF frame is kept. Messages that
came together, each taken whole or not at all, pose the frames of the scene that hang on what they
bring. No ROS import.

A pose is as old as the oldest moving transform in its chain, so a gap in TF makes poses stale.
A transform that is older than the one that is known is ignored, but when time has gone back by
more than a second (a bag begins anew) what was known from ``/tf`` is forgotten.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError, FrameId, FramePoseVector
from drake_geom_ros.math.batched import matrices_from_poses, poses_from_matrices
from drake_geom_ros.ros.conversions.fields import seconds_of
from drake_geom_ros.ros.scene.clocks import ALWAYS, Arrival, Clocks, Since
from drake_geom_ros.ros.scene.editable_scene import EditableScene
from drake_geom_ros.ros.scene.pose_ages import time_of

_REWIND = 1.0  # [s] an older stamp than this is no late message: time has gone back
_BY_TURNS = 1.0  # [s] who goes back to a parent that soon has two, and is not handed over
_REMEMBERED = 5.0  # [s] for which two parents are told after they were seen
_SHOWN = 5  # frames in a sentence, and sentences
_MOST_FRAMES = 100_000  # TF frames that are kept (60 MB): names that are ever new must end
# [m] longest translation: chains of so many stay within what a scene takes, 2**1004 m.
_FARTHEST = 2.0**900

Floats = NDArray[np.float64]


class _Edge(NamedTuple):
    """The newest transform of a TF frame C in its parent P."""

    parent: str
    R_PC: Floats
    p_PC: Floats  # [m]
    stamp: float  # [s] of the message; inf for a static one
    since: Since


class _Placed(NamedTuple):
    """Where a TF frame is in the world, and since when."""

    R_WF: Floats
    p_WF: Floats  # [m]
    since: Since


_WORLD = _Placed(np.eye(3), np.zeros(3), ALWAYS)


class TfInput:
    """Keeps the tree of TF, and poses the frames of a live scene by it."""

    def __init__(self, clocks: Clocks) -> None:
        self._clocks = clocks
        self._edges: dict[str, _Edge] = {}
        self._changed: set[str] = set()  # the TF frames of which was heard since the last time
        self._left: dict[
            str, tuple[str, float]
        ] = {}  # the former parent, and when [s] it was left
        self._claims: dict[str, tuple[str, float]] = {}  # what is wrong, and since when [s]
        self._loops: list[str] = []
        self._stamp: Any = None
        self._version = -1
        self._scene_frames: list[tuple[FrameId, tuple[str, ...]]] = []
        self._unknown: set[FrameId] = set()  # that TF knows, but not their parents

    def hear(self, message: Any, *, static: bool, waited: float = 0.0) -> None:
        """Take a TFMessage whole, which came ``waited`` [s] ago; ``pose`` does what it says.

        Raises RuntimeError, and nothing is taken, for a transform that is none and for too many
        frames.
        """
        fresh = self._read(message.transforms, static, self._clocks.arrival(waited))
        self._refuse_too_many(fresh)
        if not static:
            self._notice_rewind(fresh)
        changed = set()
        for child, edge in fresh:
            if self._is_news(child, edge):
                self._notice_claims(child, edge)
                self._edges[child] = edge
                changed.add(child)
        # What is static holds at any time: its own does not tell how new the poses are.
        if changed and (not static or self._stamp is None):
            fresh_stamps = [
                entry.header.stamp
                for entry in message.transforms
                if _plain(entry.child_frame_id) in changed
            ]
            self._stamp = max(fresh_stamps, key=time_of)
        self._changed |= changed

    def pose(self, scene: EditableScene) -> int:
        """Pose what hangs on what was heard since the last time; return how many frames."""
        changed, self._changed = self._changed, set()
        return self._pose(scene, changed)

    def follow(self, scene: EditableScene) -> int:
        """Pose the frames of a changed scene by what is known; return how many were posed."""
        return self._pose(scene, set()) if self._version != scene.version else 0

    def _read(self, transforms: Any, static: bool, arrival: Arrival) -> list[tuple[str, _Edge]]:
        """Return TransformStamped messages as child's name and edge each."""
        rows = np.zeros((len(transforms), 7))
        for row, entry in zip(rows, transforms, strict=True):
            p, q = entry.transform.translation, entry.transform.rotation
            row[:] = p.x, p.y, p.z, q.x, q.y, q.z, q.w
        R_PCs, p_PCs = matrices_from_poses(rows, 'transforms')
        if np.abs(p_PCs).max(initial=0.0) > _FARTHEST:
            far = transforms[int(np.abs(p_PCs).max(axis=1).argmax())]
            raise ArgumentError(
                f'the translation of {far.child_frame_id[:80]!r} in {far.header.frame_id[:80]!r} '
                f'has a coordinate beyond {_FARTHEST:.3g} m'
            )
        stamp, since = math.inf, ALWAYS
        edges = []
        for entry, R_PC, p_PC in zip(transforms, R_PCs, p_PCs, strict=True):
            parent, child = _plain(entry.header.frame_id), _plain(entry.child_frame_id)
            if not parent or not child or parent == child:
                raise ArgumentError(
                    f'a transform of {child[:80]!r} in {parent[:80]!r}: both must be named, and '
                    'differ'
                )
            if not static:
                stamp = seconds_of(entry.header.stamp)
                since = arrival.since(stamp)
            edges.append((child, _Edge(parent, R_PC, p_PC, stamp, since)))
        return edges

    def _refuse_too_many(self, fresh: list[tuple[str, _Edge]]) -> None:
        """Raise ArgumentError where more frames would be known than are kept."""
        if len(self._edges) + len(fresh) > _MOST_FRAMES:
            count = len(self._edges.keys() | {child for child, _ in fresh})
            if count > _MOST_FRAMES:
                raise ArgumentError(
                    f'{len(fresh)} transforms would make {count} TF frames known; at most '
                    f'{_MOST_FRAMES} are kept'
                )

    def _notice_rewind(self, fresh: list[tuple[str, _Edge]]) -> None:
        """Forget all moving transforms when time has gone back."""
        for child, edge in fresh:
            known = self._edges.get(child)
            if known and known.stamp < math.inf and edge.stamp < known.stamp - _REWIND:
                self._edges = {c: e for c, e in self._edges.items() if e.stamp == math.inf}
                return

    def troubles(self) -> list[str]:
        """Return what is wrong with the tree of TF now, in words."""
        now = self._clocks.steady()
        claims = [told for told, heard in self._claims.values() if now - heard < _REMEMBERED]
        return claims[:_SHOWN] + self._loops[:_SHOWN]

    def _notice_claims(self, child: str, edge: _Edge) -> None:
        """Notice a frame that has two parents by turns; to change the parent once is no fault."""
        known = self._edges.get(child)
        if known is None or known.parent == edge.parent:
            return
        now = self._clocks.steady()
        former, left = self._left.get(child, ('', -math.inf))
        if former == edge.parent and now - left < _BY_TURNS:
            both = ' and '.join(repr(name[:80]) for name in sorted((known.parent, edge.parent)))
            told = f'the TF frame {child[:80]!r} has two parents by turns, {both}: who sends them?'
            self._claims[child] = told, now
        self._left[child] = known.parent, now

    def _is_news(self, child: str, edge: _Edge) -> bool:
        known = self._edges.get(child)
        return known is None or known.stamp == math.inf or edge.stamp >= known.stamp

    def _pose(self, scene: EditableScene, changed: set[str]) -> int:
        """Pose the frames of the scene whose chains hold a changed transform; return how many."""
        if self._version != scene.version:
            changed = set(self._edges)
        placed: dict[str, _Placed | None] = {scene.world_frame: _WORLD}
        self._loops = []
        moved: dict[str, bool] = {}
        found: dict[FrameId, _Placed] = {}
        affected = set()
        for frame, names in self._names_of_frames(scene):
            name = next((n for n in names if n in self._edges), None)
            if name is not None and (here := self._place(name, placed)) is not None:
                found[frame] = here
                if self._hangs_on(name, changed, moved):
                    affected.add(frame)
        inspector = scene.inspector
        # Of a nested frame the pose in its parent changes when either moves; while the parent
        # waits for a pose from elsewhere it is not known.
        affected |= self._unknown
        to_pose = [f for f in found if affected & {f, inspector.GetParentFrame(f)}]
        query = scene.query
        self._unknown = {
            f
            for f in to_pose
            if not ((P := inspector.GetParentFrame(f)) in found or query.is_placed(P))
        }
        to_pose = [f for f in to_pose if f not in self._unknown]
        if to_pose:
            X_PFs = [
                _in_parent(scene, inspector.GetParentFrame(f), found[f], found) for f in to_pose
            ]
            ids = np.array([frame.get_value() for frame in to_pose], dtype=np.int64)
            rows = poses_from_matrices([R for R, _ in X_PFs], [p for _, p in X_PFs])
            posed = {frame.get_value(): found[frame].since for frame in to_pose}
            scene.pose(FramePoseVector.FromArrays(ids, rows), posed, self._stamp)
        return len(to_pose)

    def _names_of_frames(self, scene: EditableScene) -> list[tuple[FrameId, tuple[str, ...]]]:
        """Return the frames of the scene and the TF names that each answers to."""
        if self._version != scene.version:
            names = scene.names
            self._scene_frames = []
            for frame, full in names.frame_names.items():
                if frame != names.world:
                    source, _, short = full.partition('::')
                    unique = names.frames_called(short) == [frame]
                    tf_names = (f'{source}/{short}', short) if unique else (f'{source}/{short}',)
                    self._scene_frames.append((frame, tf_names))
            self._version = scene.version
        return self._scene_frames

    def _place(self, name: str, placed: dict[str, _Placed | None]) -> _Placed | None:
        """Return where a TF frame is in the world; None where no chain leads there."""
        chain = []
        while name not in placed:
            placed[name] = None  # what is not known leads nowhere, and neither does a loop
            if name in self._edges:
                chain.append(name)
                name = self._edges[name].parent
        base = placed[name]
        if name in chain:
            loop = ', '.join(sorted(repr(n[:80]) for n in chain[chain.index(name) :][:_SHOWN]))
            self._loops.append(f'the chain of these TF frames is a loop: {loop}')
        for child in reversed(chain):
            if base is not None:
                edge = self._edges[child]
                base = _Placed(
                    base.R_WF @ edge.R_PC,
                    base.p_WF + base.R_WF @ edge.p_PC,
                    Since(*map(min, base.since, edge.since)),
                )
            placed[child] = base
        return base

    def _hangs_on(self, name: str, changed: set[str], known: dict[str, bool]) -> bool:
        """Return whether the chain from a TF frame to the world holds a changed transform."""
        chain = []
        while name in self._edges and name not in known:
            chain.append(name)
            if name in changed:
                known[name] = True
                break
            name = self._edges[name].parent
        found = known.get(name, False)
        known |= dict.fromkeys(chain, found)
        return found


def _in_parent(
    scene: EditableScene, parent: FrameId, here: _Placed, found: dict[FrameId, _Placed]
) -> tuple[Floats, Floats]:
    """Return R_PF, p_PF: TF tells where P is, or else the live scene does."""
    if parent == scene.names.world:
        return here.R_WF, here.p_WF
    if parent in found:
        R_WP, p_WP = found[parent].R_WF, found[parent].p_WF
    else:
        X_WP = scene.query.X_WF(parent)
        R_WP, p_WP = X_WP.rotation().matrix(), X_WP.translation()
    return R_WP.T @ here.R_WF, R_WP.T @ (here.p_WF - p_WP)


def _plain(name: str) -> str:
    """Return a TF frame's name without the leading slash that TF once had."""
    return name.removeprefix('/')
