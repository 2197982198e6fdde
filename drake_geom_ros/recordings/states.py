"""States of a played scene in blocks: poses of moving frames over one static scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import FrameId, FramePoseVector, QueryObject, SceneGraphContext
from drake_geom_ros.live.conversions.names import TRACKED
from drake_geom_ros.live.inputs.pose_runs import PoseRun
from drake_geom_ros.live.scene.clocks import Since
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.recordings.pair_sets import PairSet, SelectedPairs, selected_pairs
from drake_geom_ros.recordings.playback import Playback

_NUMBERS = 2**20  # in a block's poses: 8 MB
_MOST_STATES = 16384


@dataclass(frozen=True)
class Block:
    """N consecutive states of one scene."""

    context: SceneGraphContext  # static poses, and arbitrary ones of frames without a pose
    selected: tuple[SelectedPairs, ...]  # of each set of pairs
    frames: Indices  # (n,) id values of the moving frames
    times: Indices  # (N,) [ns]
    poses: Floats  # (N, n, 7) X_PF as received
    ages: Floats  # (N, sets) [s] of the oldest pose used; inf: unknown
    waiting: tuple[FrameId, ...]  # frames without a pose

    def context_query(self) -> QueryObject:
        """Return a query object of the static scene."""
        return QueryObject(self.context)

    def alone(self, state: int) -> Block:
        """Return a block of only one state."""
        one = slice(state, state + 1)
        own = {name: getattr(self, name)[one].copy() for name in ('times', 'poses', 'ages')}
        return replace(self, **own)

    def digest(self) -> str:
        """Return a digest of the states, which is equal in other processes."""
        inspector = self.context_query().inspector()
        names = [inspector.full_name(FrameId(value)) for value in self.frames.tolist()]
        sha = sha256('\n'.join(names).encode())
        considered = (pairs.considered for pairs in self.selected)
        for values in (self.times, self.poses, self.ages, *considered):
            sha.update(str(values.shape).encode() + values.tobytes())
        return sha.hexdigest()

    def narrowed(self, pairs: SelectedPairs) -> SceneGraphContext:
        """Return the static scene restricted to some pairs."""
        return self.context.narrowed(pairs.considered)


class _Latest:
    """The latest received poses by frame."""

    def __init__(self) -> None:
        self.generation = 0  # grows with new frames, and when a frame outside the states moves
        self.columns: dict[int, int] = {}
        self.rows: Floats = np.zeros((0, 7))
        self.still: set[int] = set()  # received frames that are not part of states
        self._places: dict[bytes, tuple[Indices, Indices]] = {}  # by list of ids

    def forget(self) -> None:
        """Forget all frames, which another scene replaces."""
        self.__init__()  # type: ignore[misc]

    def update(self, ids: Indices, rows: Floats) -> None:
        """Store the poses (n, 7) of frames."""
        key = ids.tobytes()
        if key not in self._places:
            self._learn(key, ids)
        columns, still = self._places[key]
        if still.size and (rows[still] != self.rows[columns[still]]).any():
            self.generation += 1
        self.rows[columns] = rows

    def set_still(self, frames: set[int]) -> None:
        """Set the frames that are not part of states."""
        if frames != self.still:
            self.still = frames
            self._places.clear()

    def _learn(self, key: bytes, ids: Indices) -> None:
        new = [frame for frame in ids.tolist() if frame not in self.columns]
        if new:
            self.generation += 1
            self.columns.update(
                zip(new, range(len(self.rows), len(self.rows) + len(new)), strict=True)
            )
            self.rows = np.vstack((self.rows, np.zeros((len(new), 7))))
        if len(self._places) >= 1000:  # a sender whose lists of frames never repeat
            self._places.clear()
        columns = np.array([self.columns[frame] for frame in ids.tolist()], dtype=np.int64)
        still = np.flatnonzero([frame in self.still for frame in ids.tolist()])
        self._places[key] = columns, still


class Travelled:
    """Accumulator of the way that the frames of a recording travelled."""

    def __init__(self) -> None:
        self.in_all = 0.0  # until the last state
        self._before: Block | None = None

    def take(self, block: Block) -> Floats:
        """Return the way (N,) until each state of a block; new frames begin at rest."""
        poses, before, self._before = block.poses, self._before, block
        is_same = before is not None and np.array_equal(before.frames, block.frames)
        first = before.poses[-1:] if before is not None and is_same else poses[:1]
        poses = np.concatenate((first, poses))
        way = np.linalg.norm(np.diff(poses[..., :3], axis=0), axis=-1)
        # The chord of two quaternions resolves small angles that a cosine loses.
        same, turned = (
            np.linalg.norm(poses[1:, :, 3:] - sign * poses[:-1, :, 3:], axis=-1)
            for sign in (1, -1)
        )
        half = np.arcsin(np.minimum(np.minimum(same, turned) / 2.0, 1.0))
        # One running sum over all states, so that rounding does not depend on block sizes.
        steps = np.concatenate(([self.in_all], (way + 4.0 * half).sum(axis=1)))
        travelled = np.cumsum(steps)[1:]
        self.in_all = float(travelled[-1])
        return travelled


class RunStates(NamedTuple):
    """The states of a run."""

    times: list[int]  # (n,) [ns]
    messages: list[int]  # (n,) number of messages of the run before the state
    ages: list[list[float]]  # (n, sets) [s] of the oldest pose used


class PoseSince:
    """Times since when the poses used by a set of pairs hold; in a run, by sender."""

    def __init__(
        self, scene: HeldScene, needed: Collection[FrameId], run: PoseRun | None = None
    ) -> None:
        frames = {frame.get_value() for frame in needed}
        still = frames if run is None else frames.difference(run.ids.tolist())
        self._still = {scene.poses.since(FrameId(value)) for value in still}
        groups = () if run is None else run.groups
        self._groups = [group for group in groups if not frames.isdisjoint(group.frames)]

    def oldest(self, age: Callable[[Since], float], heard: Sequence[Since] = ()) -> float:
        """Return the age [s] of the oldest pose, by the last message of each sender."""
        since = {*self._still, *(group.since(heard) for group in self._groups)}
        return max((math.inf if each is None else age(each) for each in since), default=0.0)


class StateBlocks:
    """Collects the states of a played scene; a block ends if it is full or the scene changes."""

    def __init__(self, playback: Playback, pairs: Sequence[PairSet]) -> None:
        self._playback = playback
        self._pairs = pairs
        self._latest = _Latest()
        self._version, self._generation = -1, -1
        self._met = set[str]()  # sets that had pairs once
        self._times: list[int] = []
        self._run_ages: list[PoseSince] = []
        with playback.live.editing() as scene:
            self._watch(scene)

    def take(self, time: int) -> Iterator[Block]:
        """Add the current state at ``time`` [ns]; yield the block that this completes."""
        with self._playback.live.editing() as scene:
            yield from self._ready(scene)
            k = len(self._times)
            self._poses[k] = self._latest.rows[self._moving]
            age = self._playback.clocks.ages()
            for s, pairs in enumerate(self._selected):
                self._ages[k, s] = PoseSince(scene, pairs.needed).oldest(age)
            self._times.append(time)
        if len(self._times) == len(self._poses):
            yield from self.rest()

    def begin_run(self, run: PoseRun) -> Iterator[Block]:
        """Prepare for the states of a run; yield the block that this completes."""
        with self._playback.live.editing() as scene:
            yield from self._ready(scene)
            self._run_ages = [PoseSince(scene, each.needed, run) for each in self._selected]

    def ages_of_run(self, heard: Sequence[Since]) -> list[float]:
        """Return the current age [s] of the oldest pose that each set of pairs uses."""
        age = self._playback.clocks.ages()
        return [each.oldest(age, heard) for each in self._run_ages]

    def take_run(self, run: PoseRun, states: RunStates) -> Iterator[Block]:
        """Add the states of a run; yield the blocks that are full."""
        moving = {frame: k for k, frame in enumerate(self._frames.tolist())}
        columns = np.array([moving[frame] for frame in run.ids.tolist()], dtype=np.int64)
        latest = self._latest.rows[self._moving]
        done, count = 0, len(states.times)
        while done < count:
            k = len(self._times)
            more = min(count - done, len(self._poses) - k)
            part, here = slice(done, done + more), slice(k, k + more)
            self._poses[here] = latest
            self._poses[here, columns] = run.rows[states.messages[part]]
            self._ages[here] = states.ages[part]
            self._times += states.times[part]
            done += more
            if len(self._times) == len(self._poses):
                yield from self.rest()

    def _ready(self, scene: HeldScene) -> Iterator[Block]:
        if scene.model.version != self._version or self._generation != self._latest.generation:
            yield from self.rest()
            self._begin(scene)

    def rest(self) -> Iterator[Block]:
        """Yield the states that were added and not yielded yet."""
        if count := len(self._times):
            times, self._times = np.array(self._times, dtype=np.int64), []
            yield Block(
                context=self._context,
                selected=self._selected,
                frames=self._frames,
                times=times,
                poses=self._poses[:count].copy(),
                ages=self._ages[:count].copy(),
                waiting=self._waiting,
            )

    def _watch(self, scene: HeldScene) -> None:
        scene.poses.keep_rows = self._update
        self._watched = scene.model.version

    def _update(self, ids: Indices, rows: Floats) -> None:
        with self._playback.live.reading() as scene:
            if scene.model.version != self._watched:  # frames of another scene
                self._latest.forget()
                self._watched = scene.model.version
        self._latest.update(ids, rows)

    def _may_be_empty(self, pairs: PairSet) -> bool:
        of_trackers = any(side.startswith(TRACKED) for side in (pairs.side_a, pairs.side_b))
        return pairs.name in self._met or (of_trackers and self._playback.has_trackers)

    def _begin(self, scene: HeldScene) -> None:
        """Begin a block with the current scene."""
        if scene.model.version != self._watched:
            self._latest.forget()
            self._watched = scene.model.version
        welded = {frame.get_value() for frame in scene.model.filter_manager.welded_frames()}
        self._latest.set_still((welded | scene.model.attached) & self._latest.columns.keys())
        moving = [f for f in self._latest.columns if f not in self._latest.still]
        self._frames = np.array(moving, dtype=np.int64)
        self._moving = np.array([self._latest.columns[f] for f in moving], dtype=np.int64)
        self._context = scene.view().context
        self._selected = tuple(
            selected_pairs(
                QueryObject(self._context), pairs, may_be_empty=self._may_be_empty(pairs)
            )
            for pairs in self._pairs
        )
        self._met.update(pairs.name for pairs in self._pairs)
        # Frames without a pose are in no considered pair; any pose lets other pairs be queried.
        self._waiting = tuple(QueryObject(self._context).waiting_frames())
        anywhere = FramePoseVector({frame: RigidTransform() for frame in self._waiting})
        self._context.UpdateFramePoses(anywhere)
        most = max(1, min(_MOST_STATES, _NUMBERS // max(1, 7 * len(moving))))
        self._poses = np.zeros((most, len(moving), 7))
        self._ages = np.zeros((most, len(self._pairs)))
        self._version, self._generation = scene.model.version, self._latest.generation
