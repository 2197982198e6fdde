"""Reads messages that come as bytes: by their layout where that is known, else as rclpy does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.misread_numbers import refuse_misread_numbers
from drake_geom_ros.live.conversions.serialized_poses import PoseReader
from drake_geom_ros.live.conversions.serialized_tracked import TrackedObjectsBytes


class BytesReader(Protocol):
    """Reads what is laid out as it expects."""

    def read(self, raw: bytes, sender: str = '') -> Any:
        """Return the message of a sender; None where it is laid out otherwise."""


class MessageReader:
    """Reads the messages of one type."""

    def __init__(
        self, kind: Any, by_bytes: BytesReader, convert: Callable[[Any], Any] | None = None
    ) -> None:
        """``convert`` makes of a message of rclpy what ``by_bytes`` makes of its bytes."""
        self._kind, self._by_bytes, self._convert = kind, by_bytes, convert

    def read(self, raw: bytes, sender: str) -> Any:
        """Return a message; raises ArgumentError for what is none, or holds misread numbers."""
        message = self._by_bytes.read(raw, sender)
        if message is None:
            message = self._deserialized(raw)
        refuse_misread_numbers(message)
        return message

    def _deserialized(self, raw: bytes) -> Any:
        try:
            message = deserialize_message(raw, self._kind)
        except Exception as error:  # rclpy does not export its types of errors
            name = f'{self._kind.__module__.partition(".")[0]}/{self._kind.__name__}'
            raise ArgumentError(f'{len(raw)} bytes are no {name}: {error}') from None
        return message if self._convert is None else self._convert(message)


def pose_reader(kind: Any) -> MessageReader:
    """Return the reader of JointState, FramePoses or FrameTwists."""
    return MessageReader(kind, PoseReader(kind.__name__, time_of))


def tracked_objects_reader(kind: Any) -> MessageReader:
    """Return the reader of TrackedObjects."""
    return MessageReader(kind, TrackedObjectsBytes(time_of))


def time_of(seconds: int, nanoseconds: int) -> Any:
    """Return a builtin_interfaces/Time."""
    return Time(sec=seconds, nanosec=nanoseconds)
