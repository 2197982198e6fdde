"""Listens to TF: what comes together is taken together, and may be too much to be read."""

from __future__ import annotations

from functools import partial

from rclpy.callback_groups import CallbackGroup
from rclpy.serialization import deserialize_message

from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.ros.surface import Surface, transforms
from drake_geom_ros.ros.together import Together


def listen_to_tf(
    surface: Surface, stream: PoseStream, guard: Guard, group: CallbackGroup, clocks: Clocks
) -> TfInput:
    """Pose by what comes on /tf and /tf_static; return what is known of it.

    Raises ImportError without tf2_msgs, which not every installation has.
    """
    from tf2_msgs.msg import TFMessage

    tf = TfInput(clocks)
    for static, topic in ((True, '/tf_static'), (False, '/tf')):

        def hear(
            raw: bytes, waited: float, sender: str, static: bool = static, topic: str = topic
        ) -> None:
            message = deserialize_message(raw, TFMessage)
            refusal = stream.hear_transforms(tf, static, message, waited, sender)
            if refusal.transforms:
                guard.refuse(topic, refusal.reason, refusal.transforms)

        together = Together(
            partial(guard.take, topic, hear),
            partial(guard.take, topic, stream.pose_by_transforms),
            may_pass_over=not static,
        )
        together.subscription = surface.subscription(
            TFMessage, topic, together, transforms(static=static), group, raw=True
        )
    return tf
