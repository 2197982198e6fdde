"""Inputs that pose frames, and the frames that follow them: for a node and for a recording."""

from __future__ import annotations

from drake_geom_ros.live.conversions.message_types import (
    FramePosesMessage,
    JointStateMessage,
)
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.held_scene import HeldScene


class PoseInputs:
    """Poses by ``~/frame_poses``, TF and joint values; returned is how many frames were posed.

    What waited for [s] is how long ago a message came, ``sender`` the identity of its publisher,
    empty where nobody knows it. Raises RuntimeError to refuse one.
    """

    def __init__(self, tf: TfInput | None = None, joints: JointInput | None = None) -> None:
        """``tf`` and ``joints`` are what may hang on frames that others pose."""
        self.tf = tf
        self.joints = joints

    def take_poses(
        self, scene: HeldScene, message: FramePosesMessage, waited: float = 0.0, sender: str = ''
    ) -> int:
        """Take a FramePoses."""
        return scene.poses.take(message, waited, sender) + self.follow(scene)

    def take_joint_states(
        self,
        scene: HeldScene,
        message: JointStateMessage,
        waited: float = 0.0,
        topic: str = '',
        sender: str = '',
    ) -> int:
        """Take a JointState; ``topic`` is that of the robots that name it, empty for others."""
        if self.joints is None:
            return 0
        frames = self.joints.take(scene, message, waited, topic, sender)
        return frames and frames + self.follow(scene)

    def pose_by_transforms(self, scene: HeldScene) -> int:
        """Pose by the transforms that were heard since the last time."""
        frames = 0 if self.tf is None else self.tf.pose(scene)
        if self.tf is not None and (names := scene.poses.senders.contested_transforms()):
            scene.poses.senders.note_frames_on(names, self.tf.frames_on(scene, names))
        return frames and frames + (0 if self.joints is None else self.joints.follow(scene))

    def follow(self, scene: HeldScene) -> int:
        """Pose what hangs on frames that moved, or is new."""
        frames = 0 if self.tf is None else self.tf.follow(scene)
        return frames + (0 if self.joints is None else self.joints.follow(scene))

    def troubles(self, scene: HeldScene, stale_after: float) -> list[str]:
        """Return what is wrong with transforms and joint values, in words."""
        troubles = [] if self.tf is None else self.tf.troubles(scene)
        return troubles + ([] if self.joints is None else self.joints.troubles(scene, stale_after))
