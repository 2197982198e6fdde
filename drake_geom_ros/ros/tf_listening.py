"""Listens to TF: what comes together is taken together, and may be too much to be read."""

from __future__ import annotations

from functools import partial

from rclpy.callback_groups import CallbackGroup

from drake_geom_ros.live.conversions.serialized_transforms import TransformReader
from drake_geom_ros.live.conversions.transforms import transforms_of
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.ros.message_reading import MessageReader, time_of
from drake_geom_ros.ros.queue_reader import QueueReader
from drake_geom_ros.ros.surface import Surface
from drake_geom_ros.ros.topics import TF, TF_STATIC, Input


def listen_to_tf(
    surface: Surface, stream: PoseStream, guard: Guard, group: CallbackGroup, clocks: Clocks
) -> TfInput:
    """Pose by what comes on /tf and /tf_static; return what is known of it.

    Raises ImportError without tf2_msgs, which not every installation has.
    """
    tf = TfInput(clocks)
    for row in (TF_STATIC, TF):
        kind, static = row.type(), row is TF_STATIC
        reader = MessageReader(kind, TransformReader(time_of), transforms_of)

        def hear(
            raw: bytes,
            waited: float,
            sender: str,
            row: Input = row,
            reader: MessageReader = reader,
        ) -> None:
            transforms = reader.read(raw, sender)
            refusal = stream.hear_transforms(tf, row is TF_STATIC, transforms, waited, sender)
            if refusal.transforms:
                guard.refuse(row.topic, refusal.reason, refusal.transforms)

        together = QueueReader(
            partial(guard.take, row.topic, hear),
            partial(guard.take, row.topic, stream.pose_by_transforms),
            may_pass_over=not static,
        )
        together.subscription = surface.subscription(
            kind, row.topic, together, row.profile(), group, raw=True
        )
    return tf
