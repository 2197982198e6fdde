"""Frame poses from TF: ``/tf`` and ``/tf_static`` when the parameter ``use_tf`` is set.

A frame of the scene takes the transform of the TF frame that bears its name, ``source/frame`` or
``frame``; a name that two frames of the scene answer to poses neither. The chain of TF must lead
to the world frame, or to a frame on it that the scene file or ``~/frame_poses`` posed, such as a
robot's base with the key ``pose``. Nothing is looked up later: the newest transform of each TF
frame is kept.
Messages that came together pose the frames of the scene that hang on what they bring; of a message
what is no transform is left out.

A frame that ``~/frame_poses`` posed since is left alone until its own transform comes anew: what
was let go is not torn away by the gripper that it was in.

A pose is as old as the oldest moving transform in its chain, so a gap in TF makes poses stale.
A transform that is older than the one that is known is ignored, but when time has gone back by
more than a second (a bag begins anew) what was known from ``/tf`` is forgotten.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable, Mapping
from typing import Any

import numpy as np

from drake_geom_ros.geometry import ArgumentError, FrameId, FramePoseVector
from drake_geom_ros.live.conversions.message_types import TFMessage
from drake_geom_ros.live.conversions.transforms import (
    TransformNames,
    Transforms,
    transforms_of,
)
from drake_geom_ros.live.inputs.tf_chains import (
    WORLD,
    Chains,
    Placed,
    PosedByRun,
    Posing,
    groups_of,
    hangs_on,
    held_since,
    parts_of,
    placed,
    poses_in,
)
from drake_geom_ros.live.inputs.tf_edges import Refusal, judged
from drake_geom_ros.live.inputs.tf_past import Chain, TfPast
from drake_geom_ros.live.inputs.tf_table import Edge, EdgeTable, HeardTransforms, moments_of
from drake_geom_ros.live.inputs.tf_troubles import SHOWN, Claims, shared, unlinked
from drake_geom_ros.live.scene.clocks import ALWAYS, Clocks, Since
from drake_geom_ros.live.scene.feeders import TF
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats, Indices

_GONE = 1.0  # [s] a name of which nothing is heard so much longer than of the other is not in use
_REWIND = 1.0  # [s] an older stamp than this is no late message: time has gone back
_MOST_FRAMES = 100_000  # TF frames that are kept (60 MB): names that are ever new must end
_NO_ROWS = np.zeros(0, dtype=np.int64)
_MOST_POSINGS = 64  # sets of transforms that come together of which it is kept what they pose


class TfInput:
    """Keeps the tree of TF, and poses the frames of a live scene by it."""

    def __init__(self, clocks: Clocks) -> None:
        self._clocks = clocks
        self._edges = EdgeTable()
        self._changed = frozenset[str]()  # the TF frames of which was heard since the last time
        self._claims = Claims()
        self._past = TfPast(self.edge)
        self._loops: tuple[str, ...] = ()
        self._stamp: Any = None
        self._version = self._named_version = -1
        self._scene_frames: list[tuple[FrameId, tuple[str, ...]]] = []
        self._unknown: frozenset[FrameId] = frozenset()  # that TF knows, but not their parents
        self._loose: frozenset[str] | None = None  # parents that are no child; None: to be found
        # The names of frames that TF has by two; None: to be found.
        self._two_names: list[tuple[str, ...]] | None = None
        self._posings: dict[Hashable, Posing] = {}  # what transforms pose, for the tree of now
        self._chained: dict[FrameId, str] = {}  # of whose chains the past is kept
        self._footing: dict[str, tuple[bytes, Since]] = {}  # as chains were followed last

    def hear(self, message: TFMessage, *, static: bool, waited: float = 0.0) -> Refusal:
        """Take the transforms of a TFMessage: see ``take``."""
        return self.take(transforms_of(message), static=static, waited=waited)

    def take(self, transforms: Transforms, *, static: bool, waited: float = 0.0) -> Refusal:
        """Take the transforms of a message that came ``waited`` [s] ago; ``pose`` poses by them.

        Return what was not taken of it. Raises RuntimeError, and nothing is taken, for too many
        frames.
        """
        names = transforms.names
        good, refusal = judged(transforms)
        self._refuse_too_many(names, good)
        stamps = np.full(len(names), math.inf) if static else transforms.seconds
        heard = HeardTransforms(
            transforms, stamps, moments_of(self._clocks.arrival(waited), stamps)
        )
        if not static:
            self._notice_rewind(heard, good)
        taken = [self._take_turn(heard, good, turn, static=static) for turn in names.turns]
        rows = np.concatenate([_NO_ROWS, *taken])
        if not rows.size:
            return refusal
        # What is static holds at any time: its own does not tell how new the poses are.
        if not static or self._stamp is None:
            self._stamp = transforms.newest_stamp(rows)
        changed = names.children
        if len(rows) < len(names):
            changed = frozenset(names.pairs[k][1] for k in rows.tolist())
        self._changed = self._changed | changed if self._changed else changed
        return refusal

    def _take_turn(
        self, heard: HeardTransforms, good: Indices, turn: Indices, *, static: bool
    ) -> Indices:
        """Take those of some transforms that are good and no older than what is known.

        Return their rows.
        """
        names, now = heard.transforms.names, self._clocks.steady()
        chosen = turn if len(good) == len(names) else np.intersect1d(good, turn)

        def change_parent(child: str, parent: str, previous: str) -> None:
            self._claims.notice(child, parent, previous, now)

        rows, is_another_tree = self._edges.take(heard, chosen, change_parent)
        if is_another_tree:
            self._tree_has_changed()
        if not static and self._past.is_watching:
            for k in rows.tolist():
                self._past.note(names.pairs[k][1])
        return rows

    def edge(self, child: str) -> Edge | None:
        """Return the newest transform of a TF frame in its parent; None: there is none."""
        return self._edges.edge(child)

    def at(self, child: str, held: float) -> RigidTransform | str:
        """Return what a moving transform was at a time [s]: see ``TfPast``."""
        return self._past.at(child, held)

    def pose(self, scene: HeldScene) -> int:
        """Pose what hangs on what was heard since the last time; return how many frames."""
        changed, self._changed = self._changed, frozenset()
        return self._pose(scene, changed)

    def follow(self, scene: HeldScene) -> int:
        """Pose the frames of a changed scene by what is known; return how many were posed."""
        if self._version != scene.model.model_version or self._moved(self._ends(scene)):
            return self._pose(scene, frozenset())
        return 0

    def hangs_on_any(self, scene: HeldScene, frames: Collection[int]) -> bool:
        """Return whether a chain may end in one of some frames, or was not followed yet."""
        if self._version != scene.model.model_version and self._edges:
            return True
        loose = self._loose_parents()
        names = self._names_of_frames(scene) if loose else ()
        return any(f.get_value() in frames and not loose.isdisjoint(own) for f, own in names)

    def run_of(self, scene: HeldScene, X_PCs: Mapping[str, Floats]) -> PosedByRun | None:
        """Return what transforms (m, 4, 4) of TF frames pose that come again and again.

        They are of the parents that TF has for them now, and each later than the one before. None
        where a message of them could pose other frames than the next.
        """
        ends = self._ends(scene)
        is_settled = not (self._changed or self._unknown or self._moved(ends))
        if not is_settled or self._version != scene.model.model_version:
            return None
        for names in self._with_two_names(scene):
            if ALWAYS not in {self._edges.since(name) for name in names}:
                return None  # who is followed may change
        posing = self._posing(scene, frozenset(X_PCs), ends)
        if not posing.is_by_names or posing.left_out:
            return None
        rows = self._rows(scene, posing, ends, X_PCs) if posing.frames else np.zeros((0, 0, 7))
        return PosedByRun(posing.ids, rows, *parts_of(posing, ends, self._edges.since, X_PCs))

    def _loose_parents(self) -> frozenset[str]:
        """Return the parents of transforms that have no transform of their own."""
        if self._loose is None:
            parents = self._edges.parents
            self._loose = frozenset(parents.values()) - parents.keys()
        return self._loose

    def _refuse_too_many(self, names: TransformNames, good: Indices) -> None:
        """Raise ArgumentError where more frames would be known than are kept."""
        if len(self._edges) + len(good) > _MOST_FRAMES:
            count = len(self._edges) + len(self._edges.unknown(names, good))
            if count > _MOST_FRAMES:
                raise ArgumentError(
                    f'{len(good)} more transforms would make {count} TF frames; at most '
                    f'{_MOST_FRAMES} are kept'
                )

    def _notice_rewind(self, heard: HeardTransforms, good: Indices) -> None:
        """Forget all moving transforms when time has gone back."""
        before = self._edges.stamps(heard.transforms.names, good)
        if ((before < math.inf) & (heard.stamps[good] < before - _REWIND)).any():
            self._edges.forget_moving()
            self._tree_has_changed()
            self._past.forget()

    def troubles(self, scene: HeldScene) -> list[str]:
        """Return what is wrong with the tree of TF now, in words."""
        return [
            *self._claims.told(self._clocks.steady()),
            *self._loops[:SHOWN],
            *unlinked(self._edges.parents, self._names_of_frames(scene), tuple(self._ends(scene))),
            *shared(self._edges.parents, scene.model.names),
        ]

    def frames_on(self, scene: HeldScene, names: Collection[str]) -> set[int]:
        """Return the frames of the scene whose chain holds any of some TF frames."""
        followed = ((f, self._followed(own)) for f, own in self._names_of_frames(scene))
        parents, changed, answers = self._edges.parents, set(names), dict[str, bool]()
        return {f.get_value() for f, n in followed if n and hangs_on(n, changed, answers, parents)}

    def _pose(self, scene: HeldScene, heard: frozenset[str]) -> int:
        """Pose the frames of the scene whose chains hold a changed transform; return how many."""
        ends = self._ends(scene)
        posing = self._posing(scene, heard, ends)
        self._footing = {name: _footing(end) for name, end in ends.items()}
        self._loops, self._unknown = posing.loops, posing.unknown
        if scene.poses.visitors.gone_after:
            # Also one whose chain ends elsewhere was named: it waits, or is stale, and stays.
            names_of = self._names_of_frames(scene)
            scene.poses.welcome([f.get_value() for f, n in names_of if heard.intersection(n)])
        if posing.left_out:
            scene.poses.leave_out(posing.left_out)
        if posing.frames:
            rows = self._rows(scene, posing, ends, {})
            posed = groups_of(posing, self._held_since(posing, ends))
            poses = FramePoseVector.FromArrays(posing.ids, rows)
            scene.poses.pose(poses, posed, self._stamp, TF, rows, self._past, named=())
            if scene.poses.history is not None:
                followed = zip(posing.frames, posing.names, strict=True)
                unkept = {f for f, name in followed if self._chained.get(f) != name}
                if unkept:
                    self._keep_chains(scene, unkept, ends)
        return len(posing.frames)

    def _posing(
        self, scene: HeldScene, heard: frozenset[str], ends: Mapping[str, Placed]
    ) -> Posing:
        """Return the frames that received transforms pose; results by names alone are cached."""
        moved = self._moved(ends)
        is_new = self._version != scene.model.model_version
        if is_new:
            self._version = scene.model.model_version
            self._tree_has_changed()
        if is_new or moved or self._unknown:
            changed = self._edges.parents.keys() if is_new else heard
            return self._followed_up(scene, heard, changed, ends)
        by_turns = tuple(map(self._followed, self._with_two_names(scene)))
        others = scene.poses.feeders.fed_by_others(TF)
        key = heard, tuple(ends), by_turns, scene.model.attached, others
        posing = self._posings.get(key)
        if posing is None:
            posing = self._followed_up(scene, heard, heard, ends)
            if len(self._posings) >= _MOST_POSINGS:
                self._posings.clear()
            if posing.is_by_names:
                self._posings[key] = posing
        return posing

    def _followed_up(
        self,
        scene: HeldScene,
        heard: frozenset[str],
        changed: Collection[str],
        ends: Mapping[str, Placed],
    ) -> Posing:
        """Return what changed transforms pose, by following chains."""
        moved = dict.fromkeys(self._moved(ends), True)
        chains = Chains(self._edges.parents, ends)
        tf_names: dict[FrameId, str] = {}
        affected, left_out = set[FrameId](), []
        for frame, names in self._names_of_frames(scene):
            name = self._followed(names)
            if frame.get_value() in scene.model.attached:
                left_out += [frame] if name in heard else []
                continue
            if name not in heard and scene.poses.feeders.is_fed_by_others(TF, frame.get_value()):
                continue
            if name is not None and chains.lead(name):
                tf_names[frame] = name
                if hangs_on(name, changed, moved, self._edges.parents):
                    affected.add(frame)
        # Of a nested frame the pose in its parent changes when either moves; while the parent
        # waits for a pose from elsewhere it is not known.
        affected |= self._unknown
        in_parents = {f: scene.model.inspector.GetParentFrame(f) for f in tf_names}
        to_pose = [f for f, P in in_parents.items() if f in affected or P in affected]
        unknown = frozenset(
            f
            for f in to_pose
            if not ((P := in_parents[f]) in tf_names or scene.query.is_placed(P))
        )
        frames = tuple(f for f in to_pose if f not in unknown)
        world = scene.model.names.world
        parents = tuple(
            None if (P := in_parents[f]) == world else tf_names.get(P, P) for f in frames
        )
        names_of = tuple(tf_names[f] for f in frames)
        steps = chains.steps([*names_of, *(P for P in parents if isinstance(P, str))])
        troubles = tuple(chains.loops), tuple(left_out), unknown
        return Posing(frames, names_of, parents, steps, tuple(ends), *troubles)

    def _rows(
        self,
        scene: HeldScene,
        posing: Posing,
        ends: Mapping[str, Placed],
        X_PCs: Mapping[str, Floats],
    ) -> Floats:
        """Return the poses X_PF (n, 7) of frames now, or (m, n, 7) of many moments.

        ``X_PCs`` are the transforms (m, 4, 4) of TF frames at these; what else there is rests.
        """
        levels = posing.levels
        X_PC = self._edges.X_PCs(levels.names)
        if X_PCs:
            moments = len(next(iter(X_PCs.values())))
            X_PC = np.tile(X_PC, (moments, 1, 1, 1))
            for k, (_, child) in enumerate(levels.names.pairs):
                if child in X_PCs:
                    X_PC[:, k] = X_PCs[child]
        X_WEs = [end.X_WF for end in ends.values()]
        X_WEs += [scene.query.X_WF(frame).GetAsMatrix4() for frame in levels.outer]
        return poses_in(levels, placed(levels, np.array(X_WEs), X_PC))

    def _held_since(self, posing: Posing, ends: Mapping[str, Placed]) -> Floats:
        """Return since when (n, 4) the frames of a posing are where they are."""
        levels = posing.levels
        since = [*(end.since for end in ends.values()), *[ALWAYS] * len(levels.outer)]
        return held_since(levels, np.array(since), self._edges.moments(levels.names))

    def _with_two_names(self, scene: HeldScene) -> list[tuple[str, ...]]:
        """Return the names of the frames of the scene that TF has by two names."""
        if self._two_names is None:
            every = (names for _, names in self._names_of_frames(scene))
            self._two_names = [
                n for n in every if len(n) > 1 and self._edges.parents.keys() >= set(n)
            ]
        return self._two_names

    def _tree_has_changed(self) -> None:
        self._loose, self._two_names, self._chained = None, None, {}
        self._posings.clear()

    def _keep_chains(
        self, scene: HeldScene, frames: Collection[FrameId], ends: Collection[str]
    ) -> None:
        """Have the past of the transforms kept that pose frames of the scene."""
        names = self._names_of_frames(scene)
        called = {name: f for f, own in names for name in own}
        called[scene.model.world_frame] = scene.model.names.world
        for frame, own in names:
            first = self._followed(own)
            if frame not in frames or first is None:
                continue
            children, here = list[str](), first
            while here not in ends:
                children.append(here)
                here = self._edges.parents[here]
            self._past.follow(frame.get_value(), Chain(tuple(children), called[here]))
            self._chained[frame] = first

    def _ends(self, scene: HeldScene) -> dict[str, Placed]:
        """Return where chains of TF may end, by TF name: the world frame comes first.

        The others are frames on the world whose own transform TF does not have, and that were
        posed otherwise.
        """
        ends = {scene.model.world_frame: WORLD}
        names = self._loose_parents() - ends.keys()
        if not names:
            return ends
        for frame, own in self._names_of_frames(scene):
            name = next((n for n in own if n in names), None)
            if name is None or any(n in self._edges for n in own):
                continue
            since = scene.poses.since(frame)
            carrier = scene.model.inspector.GetParentFrame(frame)
            stands = carrier == scene.model.names.world or scene.model.is_mounted(frame)
            if (
                since is not None
                and stands
                and frame.get_value() not in scene.model.attached
                and scene.query.is_placed(frame)
                and not scene.poses.feeders.is_fed_by(TF, frame.get_value())
            ):
                ends[name] = Placed(scene.query.X_WF(frame).GetAsMatrix4(), since)
        return ends

    def _moved(self, ends: Mapping[str, Placed]) -> list[str]:
        """Return which ends of chains are not where they were when chains were followed last."""
        return [n for n, end in ends.items() if self._footing.get(n) != _footing(end)]

    def _names_of_frames(self, scene: HeldScene) -> list[tuple[FrameId, tuple[str, ...]]]:
        """Return the frames of the scene and the TF names that each answers to."""
        if self._named_version != scene.model.model_version:
            names = scene.model.names
            claims = names.tf_claims
            # A name that two frames answer to poses neither: see tf_troubles.shared.
            self._scene_frames = [
                (frame, tuple(n for n in names.tf_names(frame) if claims[n] == [frame]))
                for frame in names.labels
            ]
            self._named_version = scene.model.model_version
        return self._scene_frames

    def _followed(self, names: tuple[str, ...]) -> str | None:
        """Return which of its TF names a frame follows: the first that TF has.

        But for one that moved, and of which nothing was heard while another one went on: a robot
        whose prefix was taken away is followed by its plain names.
        """
        connected = [name for name in names if name in self._edges]
        if len(connected) == 2:
            first, second = (self._edges.since(name) for name in connected)
            if ALWAYS not in (first, second) and second.heard - first.heard > _GONE:
                return connected[1]
        return connected[0] if connected else None


def _footing(end: Placed) -> tuple[bytes, Since]:
    """Return where the end of a chain is, and since when, to be compared."""
    return end.X_WF.tobytes(), end.since
