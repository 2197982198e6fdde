"""Playback of a recording into a live scene, as a node would have processed its messages.

It uses the classes of the node. Steady time is the time of recording, and the node's time is the
recorded ``/clock`` if there is one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import AccuracyLike, ArgumentError
from drake_geom_ros.live.conversions.file_access import ALL_PACKAGES, FileAccess
from drake_geom_ros.live.conversions.tracked_objects import TrackedObjectsReader
from drake_geom_ros.live.inputs.joint_input import JointInput, NothingOfOursError
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.inputs.tracked_input import TrackedInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import JUMP_BACKWARD, JUMP_FORWARD, Clocks
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.recordings.raw_messages import NANOSECONDS
from drake_geom_ros.recordings.recorded_attachments import RecordedAttachments
from drake_geom_ros.recordings.recorded_robots import SceneRobots
from drake_geom_ros.recordings.recording import Recorded
from drake_geom_ros.recordings.report_record import digest
from drake_geom_ros.recordings.scene_differences import SceneDifferences
from drake_geom_ros.scene_files import SceneDescription, files_of

LOOKS = 4 * NANOSECONDS  # [ns] between two checks; a scene reports each trouble for 5 s
_MOST_TROUBLES = 200
_BY_IDS = (
    'frame_ids are numbers of the node that ran, which a recording does not explain: have the '
    'sender give frame_names'
)


class Trouble(NamedTuple):
    """A trouble with its first and last time [ns], and the number of occurrences."""

    words: str
    first: int
    last: int
    seen: int
    is_doubt: bool = False  # true: it is doubtful which poses held, and so are the results


class RefusedMessages(NamedTuple):
    """Refused messages of a topic, in whole or in part."""

    topic: str
    seen: int  # number of messages
    reason: str  # of the first one

    def in_words(self) -> str:
        """Return a text about the refusals."""
        return f'{counted(self.seen, "message")} of {self.topic} refused, first: {self.reason}'


class ClockTimes(NamedTuple):
    """Times of the clocks [s]; ``simulated`` is None without a recorded clock."""

    recorded: float
    simulated: float | None


class _Times:
    """Replacements of a node's clocks, with times in [s]."""

    def __init__(self, *, simulated: bool) -> None:
        self.recorded = 0.0
        self.simulated = 0.0 if simulated else None

    def steady(self) -> float:
        return self.recorded

    def node(self) -> float:
        return self.recorded if self.simulated is None else self.simulated


def is_jump(before: Any, now: Any) -> Any:
    """Return whether simulated time [s] jumps or begins; elementwise for arrays."""
    step = now - before
    return (before == 0.0) | (step <= -JUMP_BACKWARD) | (step >= JUMP_FORWARD)


def _refuse_frame(scene: HeldScene, name: str, held: float) -> str:
    """Refuse bodies that are not in the world: reports keep no poses of then."""
    raise ArgumentError(
        f'header.frame_id is {name[:80]!r}; a report takes bodies in the world frame alone'
    )


class Playback:
    """The live scene of a recording, at the time up to which it was played."""

    def __init__(
        self,
        description: SceneDescription | None,
        stale_after: float,
        *,
        simulated: bool,
        world_frame: str = 'world',
        package_roots: Sequence[str | Path] = (),
        accuracy: AccuracyLike = 'exact',
    ) -> None:
        """Start with a scene; ``simulated``: the node's time is that of ``/clock``.

        ``stale_after`` [s] is the parameter of the node.
        """
        self._times = _Times(simulated=simulated)
        self.clocks = Clocks(self._times.node, self._times.steady)
        self.live = LiveScene(accuracy, self.clocks, world_frame)
        self.live.files = FileAccess([ALL_PACKAGES], package_roots=[str(p) for p in package_roots])
        self.stale_after = stale_after
        self.inputs = PoseInputs(
            TfInput(self.clocks), JointInput(self.clocks, stale_after, by_default=True)
        )
        self._robot = RobotInput(self.live)
        self._tracked = TrackedInput(self.live, _refuse_frame)
        self._tracked_reader = TrackedObjectsReader()
        self.has_trackers = False  # bodies come and go with time alone
        # Digests of the files that robot descriptions named.
        self.robot_files: dict[Path, str] = {}
        self._troubles: dict[str, Trouble] = {}
        self._refused: dict[str, RefusedMessages] = {}
        self._differences = SceneDifferences()
        self._attachments = RecordedAttachments()
        self._looked = -math.inf
        if description is not None:
            with self.live.editing() as scene:
                scene.make(addition(description))
        self._scene_robots = SceneRobots(self.live)

    def robots_topics(self) -> set[str]:
        """Return the topics of joint states that robots of the scene name."""
        assert self.inputs.joints is not None
        with self.live.reading() as scene:
            return self.inputs.joints.topics(scene)

    def take_robot(self, text: str, *, is_semantic: bool = False) -> None:
        """Load a robot's description; raises RuntimeError for an invalid one.

        The description of a robot that the scene has is skipped, since the node refuses it.
        """
        if not is_semantic and self._scene_robots.has(text):
            return
        (self._robot.take_semantics if is_semantic else self._robot.take)(text)
        with self.live.editing() as scene:
            named = [*files_of(scene.model.scene_graph, ())]
        self.robot_files |= {p: digest(p) for p in named if p not in self.robot_files}

    def take(self, recorded: Recorded, role: str) -> bool:
        """Process a message; return whether it posed anything."""
        self.wait_until(recorded.time)
        if recorded.time >= self.next_look:
            if self._looked > 0:
                self.look(recorded.time)
            self._looked = recorded.time
        if recorded.message is None:
            self._refuse(recorded, recorded.reason)
            return False
        try:
            return self._take(recorded, role)
        except NothingOfOursError as error:
            self._note_refusal(recorded, str(error))  # of another robot, so nothing is lost
            return False
        except RuntimeError as error:
            self._refuse(recorded, str(error))
            return False

    @property
    def refused(self) -> list[RefusedMessages]:
        """Refusals, by topic, of messages that may have concerned the scene."""
        return list(self._refused.values())

    def differences(self) -> tuple[str, ...]:
        """Return texts on the differences between the recorded ``~/scene`` and this scene."""
        with self.live.reading() as scene:
            return tuple(self._differences.in_words(scene.model.inspector))

    @property
    def next_look(self) -> float:
        """The time [ns] from which the next message triggers a check for troubles."""
        return self._looked + LOOKS

    @property
    def moment(self) -> ClockTimes:
        """The current times of the clocks."""
        return ClockTimes(self._times.recorded, self._times.simulated)

    @moment.setter
    def moment(self, moment: ClockTimes) -> None:
        self._times.recorded, self._times.simulated = moment

    def tick(self, now: float) -> None:
        """Set simulated time to ``now`` [s], which is no jump."""
        self._times.simulated = now

    def wait_until(self, time: int) -> None:
        """Advance the time of recording to ``time`` [ns]."""
        self._times.recorded = max(self._times.recorded, time / NANOSECONDS)
        if self.has_trackers:
            self._tracked.sweep()
        with self.live.editing() as scene:
            if scene.poses.visitors.gone_after:
                scene.poses.take_out_silent(self.stale_after)

    def expect_trackers(self) -> None:
        """Have bodies of trackers from now on; until the first message their heartbeat waits."""
        self.has_trackers = True
        with self.live.editing() as scene:
            assert scene.tracked.stand is not None
            scene.tracked.stand(scene)

    def look(self, time: int) -> None:
        """Collect the current troubles at ``time`` [ns]."""
        with self.live.editing() as scene:
            doubts = set(scene.poses.sender_troubles())
            troubles = [*scene.troubles(), *self.inputs.troubles(scene, self.stale_after)]
            troubles += filter(None, [scene.waiting().in_words(), *scene.log.take()[1]])
        for words in troubles:
            self.note(words, time, is_doubt=words in doubts)

    @property
    def troubles(self) -> list[Trouble]:
        """All troubles, in the order of their first occurrence."""
        return sorted(self._troubles.values(), key=lambda trouble: trouble.first)

    def _take(self, recorded: Recorded, role: str) -> bool:
        message = recorded.message
        role, _, topic = role.partition(':')
        if role == 'clock':
            self._tick(message.clock.sec + message.clock.nanosec / NANOSECONDS, recorded.time)
            return False
        if role.startswith('robot'):
            self.take_robot(message.data, is_semantic=role.endswith('semantic'))
            role = ''
        if role == 'tracked_objects':
            bodies = self._tracked_reader.read(message, self.live.files)
            return self._tracked.take(bodies) > 0
        if role == 'scene':
            topic = recorded.topic.name
            with self.live.editing() as held:
                for reason in self._attachments.follow(topic, message, held):
                    self.note(reason, recorded.time, is_doubt=True)
                self._differences.take(topic, message, held.model.inspector)
            return False
        with self.live.editing() as scene:
            if role == 'frame_poses':
                if len(message.frame_ids):
                    raise RuntimeError(_BY_IDS)
                return self.inputs.take_poses(scene, message) > 0
            if role == 'joint_states':
                return self.inputs.take_joint_states(scene, message, topic=topic) > 0
            if role in ('tf', 'tf_static'):
                assert self.inputs.tf is not None
                refusal = self.inputs.tf.hear(message, static=role == 'tf_static')
                if refusal.transforms:
                    self._refuse(recorded, refusal.reason)
                return self.inputs.pose_by_transforms(scene) > 0
            self.inputs.follow(scene)
            return False  # a node runs no cycle for it either

    def _tick(self, now: float, time: int) -> None:
        """Set simulated time to ``now`` [s]; as in a node, a jump resets all ages."""
        before = self._times.simulated
        self.tick(now)
        if before is None or not is_jump(before, now):
            return
        self.clocks.begin_anew()
        if before:
            self.note('the recorded clock jumped: ages were unknown until new poses came', time)

    def _refuse(self, recorded: Recorded, reason: str) -> None:
        topic = recorded.topic.name
        before = self._refused.get(topic, RefusedMessages(topic, 0, reason))
        self._refused[topic] = before._replace(seen=before.seen + 1)
        self._note_refusal(recorded, reason)

    def _note_refusal(self, recorded: Recorded, reason: str) -> None:
        self.note(f'a message of {recorded.topic.name} was refused: {reason}', recorded.time)

    def note(self, words: str, time: int, *, is_doubt: bool = False) -> None:
        """Add an occurrence of a trouble at ``time`` [ns]."""
        before = self._troubles.get(words)
        if before is None and len(self._troubles) >= _MOST_TROUBLES:
            words = 'more was wrong than is told here'
            before = self._troubles.get(words)
        first, seen = (time, 0) if before is None else (before.first, before.seen)
        is_doubt |= before is not None and before.is_doubt
        self._troubles[words] = Trouble(words, first, time, seen + 1, is_doubt)
