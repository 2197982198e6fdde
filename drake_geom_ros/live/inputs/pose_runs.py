"""Runs of pose messages, evaluated together instead of one by one.

Most of what a scene hears comes from senders that name the same joints, frames or transforms each
time. While nothing else comes, such a message changes nothing but where these frames stand, and
since when.
This is computed here, for messages of several senders by turns, from the tables and functions by
which a live scene takes one message. Where a message could change more, there is no run, and
the messages are taken one by one.

Who plays a run takes one message of each sender before it and the last one of each behind it in
the usual way: so the scene is left as all of them would have left it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.live.conversions.transforms import names_in
from drake_geom_ros.live.inputs.joint_input import JointInput, base_of
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.inputs.tf_edges import matrices_of
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.clocks import ALWAYS, Since, oldest
from drake_geom_ros.live.scene.driven_robot import DrivenRobot, or_zero
from drake_geom_ros.live.scene.feeders import JOINTS, MESSAGES, TF
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.senders import may_jump_and_return
from drake_geom_ros.math.array_types import Floats, Indices


class Sender(NamedTuple):
    """Messages that name the same joints, frames or transforms, with what may differ in them.

    All are such as are taken whole: positions and speeds are finite, and no stamp is that of the
    message before. Those of TF have one stamp each, later than that of the one before, or none.
    """

    sample: Any  # one of them, a JointState, FramePoses or TFMessage
    feeder: str  # as ``feeders`` calls what poses so
    topic: str  # of joint states, as robots name it, empty for others
    before: Floats  # (k,) positions, or poses of 7 numbers each, of the message before the run
    at: Indices  # (n,) the places of its messages in the run, ascending
    numbers: Floats  # (n, k) positions or poses of these
    times: Floats  # (n + 1,) [s] stamps of the one before and of these, or when they came
    first: float  # [s] the stamp of the first of these


class PosedGroup(NamedTuple):
    """Frames that depend on the same senders."""

    frames: frozenset[int]
    senders: tuple[int, ...]
    others: Since  # since when all else holds that they depend on

    def since(self, heard: Sequence[Since]) -> Since:
        """Return since when these frames have their poses, by what was heard of each sender."""
        return oldest(self.others, *(heard[sender] for sender in self.senders))


@dataclass(frozen=True)
class PoseRun:
    """Poses of frames before m messages and after each of them."""

    ids: Indices  # (f,)
    rows: Floats  # (m + 1, f, 7) X_PF after as many messages
    groups: tuple[PosedGroup, ...]
    heard: tuple[Since, ...]  # since when the messages of each sender before the run hold

    @cached_property
    def posing(self) -> frozenset[int]:
        """The senders whose messages pose something: not all of TF is about the scene."""
        return frozenset(sender for group in self.groups for sender in group.senders)


def subjects_of(
    inputs: PoseInputs, scene: HeldScene, message: Any, feeder: str, topic: str
) -> frozenset[Any]:
    """Return what a message of a ``Sender`` names, in any way of naming."""
    if feeder == TF:
        return frozenset(child for _, child in names_in(message.transforms))
    if feeder != JOINTS:
        return frozenset(scene.model.reader.listed_in(message).frames)
    assert inputs.joints is not None
    places = inputs.joints.places(scene, topic, tuple(message.name))
    return frozenset(place for place in places if place is not None)


def run_of(
    inputs: PoseInputs, scene: HeldScene, senders: Sequence[Sender], count: int
) -> PoseRun | None:
    """Return the run of ``count`` messages of some senders; None where it is not that simple."""
    last = [np.searchsorted(each.at, np.arange(count + 1)) for each in senders]
    telling = _Telling(scene, senders, last)
    if not all(telling.tell(inputs, number) for number in range(len(senders))):
        return None
    if inputs.tf is not None and not telling.tell_chains(inputs.tf):
        return None
    if inputs.joints is not None and not telling.tell_links(inputs.joints):
        return None
    run = telling.run()
    if run is None:
        return None
    values = run.ids.tolist()
    if len(set(values)) < len(values) or not _stand_alone(inputs, scene, set(values)):
        return None
    try:  # numbers that are no poses are refused one by one, as a live scene does
        FramePoseVector.FromArrays(np.arange((count + 1) * len(values)), run.rows.reshape(-1, 7))
    except RuntimeError:
        return None
    return run


class _Telling:
    """Collects what senders pose."""

    def __init__(
        self, scene: HeldScene, senders: Sequence[Sender], last: Sequence[Indices]
    ) -> None:
        """``last`` (m + 1,) of each sender: how many messages it has sent."""
        self._scene, self._senders, self._last = scene, senders, last
        # Of each robot the columns that messages hold: by which sender, and where in its message.
        self._led: dict[str, dict[int, tuple[int, int]]] = {}
        self._told_by: dict[str, int] = {}  # which sender tells of a TF frame
        self._X_PCs: dict[str, Floats] = {}  # (m + 1, 4, 4) of it
        self._ids: list[Indices] = []
        self._rows: list[Floats] = []
        self._groups: list[PosedGroup] = []
        self._heard: dict[int, Since] = {}

    def tell(self, inputs: PoseInputs, number: int) -> bool:
        """Take a sender; return whether nobody else sends the same."""
        sender = self._senders[number]
        if sender.feeder == JOINTS:
            return inputs.joints is not None and self._lead(inputs.joints, number, sender)
        if sender.feeder == TF:
            return inputs.tf is not None and self._hear(inputs.tf, number, sender)
        ids, frames = self._scene.model.reader.listed_in(sender.sample)
        since = {self._scene.poses.ages.since(value) for value in frames}
        if len(since) != 1 or None in since:
            return False
        self._heard[number] = next(iter(since)) or ALWAYS
        if self._heard[number] == ALWAYS:  # they are declared static
            return False
        if not self._are_fed_by(MESSAGES, frames):
            return False
        self._ids.append(ids)
        self._rows.append(self._numbers(number).reshape(-1, len(ids), 7))
        self._groups.append(PosedGroup(frames, (number,), ALWAYS))
        return True

    def _lead(self, joints: JointInput, number: int, sender: Sender) -> bool:
        places = joints.places(self._scene, sender.topic, tuple(sender.sample.name))
        robots = self._scene.model.joints.robots
        for k, place in enumerate(places):
            if place is None:
                continue
            led = self._led.setdefault(place.robot, {})
            value = robots[place.robot].values[place.column]
            if place.column in led or value is None:
                return False
            led[place.column] = number, k
            if self._heard.setdefault(number, value.since) != value.since:
                return False
        return number in self._heard

    def _hear(self, tf: TfInput, number: int, sender: Sender) -> bool:
        """Take a sender of TF, whose last transforms are the newest of their children."""
        names = names_in(sender.sample.transforms)
        edges = [edge for _, child in names if (edge := tf.edge(child)) is not None]
        children = {child for _, child in names}
        if not (len(edges) == len(names) == len(children) > 0):
            return False
        is_news = all(
            edge.stamp < sender.first or edge.stamp == sender.first == 0.0 for edge in edges
        )
        if (
            not is_news
            or [edge.parent for edge in edges] != [parent for parent, _ in names]
            or len({edge.since for edge in edges}) > 1
            or not children.isdisjoint(self._told_by)
        ):
            return False
        self._heard[number] = edges[0].since
        before = np.array([[edge.X_PC for edge in edges]])
        Xs = matrices_of(sender.numbers.reshape(-1, 7)).reshape(-1, len(names), 4, 4)
        every = np.concatenate((before, Xs))[self._last[number]]
        for k, (_, child) in enumerate(names):
            self._told_by[child], self._X_PCs[child] = number, every[:, k]
        return True

    def tell_chains(self, tf: TfInput) -> bool:
        """Add the frames that transforms pose; return whether the messages form a run."""
        if not self._X_PCs:
            return True
        run = tf.run_of(self._scene, self._X_PCs)
        if run is None:
            return False
        frames_by_senders: dict[tuple[tuple[int, ...], Since], set[int]] = {}
        for value, chain, others in zip(run.ids.tolist(), run.chains, run.others, strict=True):
            senders = tuple(sorted({self._told_by[child] for child in chain}))
            frames_by_senders.setdefault((senders, others), set()).add(value)
        groups = [PosedGroup(frozenset(values), *key) for key, values in frames_by_senders.items()]
        if not self._hold(TF, groups):
            return False
        if groups:  # else no frame of the scene hangs on these transforms
            self._groups += groups
            self._ids.append(run.ids)
            self._rows.append(run.rows)
        return True

    def _are_fed_by(self, feeder: str, frames: Collection[int]) -> bool:
        """Return whether nobody else posed any of some frames last."""
        return all(self._scene.poses.feeders.is_fed_by(feeder, value) for value in frames)

    def _hold(self, feeder: str, groups: Sequence[PosedGroup]) -> bool:
        """Return whether frames are as senders left them, and none is declared static."""
        heard = [self._heard.get(k, ALWAYS) for k in range(self._count)]
        return all(
            self._are_fed_by(feeder, group.frames)
            and {self._scene.poses.ages.since(v) for v in group.frames} == {group.since(heard)}
            for group in groups
        )

    def tell_links(self, joints: JointInput) -> bool:
        """Add the links of robots whose joints are led; return whether the messages form a run."""
        for name, led in self._led.items():
            robot = self._scene.model.joints.robots[name]
            base = base_of(self._scene, robot)
            if base is None:
                return False
            groups = _groups_of(robot, led, base.since)
            rows = sorted(row for group in groups for row in group.frames)
            groups = [
                group._replace(frames=frozenset(robot.links[row] for row in group.frames))
                for group in groups
            ]
            if not self._hold(JOINTS, groups):
                return False
            self._groups += groups
            if self._may_have_two_senders(robot, led):
                return False
            positions = np.tile(robot.positions(), (len(self._last[0]), 1))
            for column, (number, k) in led.items():
                positions[:, column] = self._numbers(number, k)
            X_PLs = robot.tree.link_poses(or_zero(positions), base.X_PB)
            self._ids.append(np.array([robot.links[row] for row in rows], dtype=np.int64))
            self._rows.append(X_PLs[:, rows])
        posing = {sender for group in self._groups for sender in group.senders}
        return all(k in posing or self._senders[k].feeder == TF for k in range(self._count))

    def _may_have_two_senders(
        self, robot: DrivenRobot, led: Mapping[int, tuple[int, int]]
    ) -> bool:
        """Return whether joints jump to and fro, which shows message by message what it is."""
        for number in {number for number, _ in led.values()}:
            sender = self._senders[number]
            columns = [column for column, (each, _) in led.items() if each == number]
            values = np.vstack((sender.before, sender.numbers))
            chosen = values[:, [led[column][1] for column in columns]]
            if may_jump_and_return(robot, columns, sender.times, chosen):
                return True
        return False

    @property
    def _count(self) -> int:
        return len(self._senders)

    def _numbers(self, number: int, place: Any = slice(None)) -> Floats:
        """Return what a sender said last after each message of the run."""
        sender = self._senders[number]
        numbers: Floats = np.vstack((sender.before, sender.numbers))
        return np.asarray(numbers[self._last[number], place])

    def run(self) -> PoseRun | None:
        """Return all of it; None where nothing is posed."""
        if not self._groups:
            return None
        heard = tuple(self._heard[k] for k in range(self._count))
        ids, rows = np.concatenate(self._ids), np.concatenate(self._rows, axis=1)
        return PoseRun(ids, rows, tuple(self._groups), heard)


def _groups_of(
    robot: DrivenRobot, led: dict[int, tuple[int, int]], base: Since
) -> list[PosedGroup]:
    """Return the rows of links that led columns move, by what else they depend on."""
    rows_by_senders: dict[tuple[tuple[int, ...], Since], set[int]] = {}
    for columns, rows in robot.patterns.items():
        values = [robot.values[column] for column in columns]
        sinces = [value.since for value in values if value is not None]
        if led.keys().isdisjoint(columns) or len(sinces) < len(columns):
            continue  # they stay, or wait for a joint of which nothing was heard
        senders = tuple(sorted({led[column][0] for column in columns if column in led}))
        pairs = zip(columns, sinces, strict=True)
        others = oldest(base, *(since for column, since in pairs if column not in led))
        rows_by_senders.setdefault((senders, others), set()).update(rows)
    return [PosedGroup(frozenset(rows), *key) for key, rows in rows_by_senders.items()]


def _stand_alone(inputs: PoseInputs, scene: HeldScene, frames: set[int]) -> bool:
    """Return whether nothing hangs on frames that move but what moves with them anyway."""
    welded = scene.model.filter_manager.welded_frames()
    held = scene.model.attached | {frame.get_value() for frame in welded}
    roots = {r.root.get_value() for r in scene.model.joints.robots.values() if r.root is not None}
    return (
        frames.isdisjoint(held)
        and frames.isdisjoint(roots)
        and roots.isdisjoint(scene.model.attached)
        and (inputs.tf is None or not inputs.tf.hangs_on_any(scene, frames))
        and (inputs.joints is None or inputs.joints.has_followed(scene))
    )
