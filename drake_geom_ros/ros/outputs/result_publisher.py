"""Publishes the results of cycles as bytes, where rclpy reads these as the same message."""

from __future__ import annotations

from typing import Any

from rclpy.publisher import Publisher
from rclpy.serialization import deserialize_message

from drake_geom_ros.live.conversions.serialized_results import ResultWriter

_SCALARS = {'uint32': 7, 'uint64': 7, 'double': 0.5}
_THREE = {'boolean': [True, False, True], 'uint8': [1, 2, 3], 'string': ['a', 'bc', '']}


class ResultPublisher:
    """A publisher of one type of results, and the maker of what it publishes."""

    def __init__(self, publisher: Publisher) -> None:
        self._publisher, self._kind = publisher, publisher.msg_type
        self._writer = writer_of(self._kind)

    def make_message(self) -> Any:
        """Return an empty message to fill and publish, again and again."""
        return self._kind() if self._writer is None else self._writer.record()

    def publish(self, message: Any) -> None:
        """Publish what ``make_message`` returned."""
        writer = self._writer
        self._publisher.publish(message if writer is None else writer.bytes_of(message))

    def get_subscription_count(self) -> int:
        """Return how many listen."""
        return int(self._publisher.get_subscription_count())


def writer_of(kind: Any) -> ResultWriter | None:
    """Return the writer of a message type; None where the middleware reads something else."""
    try:
        writer, message = ResultWriter(kind), _sample(kind)
        return writer if deserialize_message(writer.bytes_of(message), kind) == message else None
    except Exception:  # another layout: rclpy does not export its types of errors
        return None


def _sample(kind: Any) -> Any:
    """Return a message with all kinds of values in its fields."""
    message = kind()
    for name, text in kind.get_fields_and_field_types().items():
        if name == 'header':
            message.header.frame_id = 'world'
            message.header.stamp.sec, message.header.stamp.nanosec = 5, 6
        elif text.startswith('sequence<'):
            element = text[len('sequence<') : -1]
            setattr(message, name, _THREE.get(element, [1, 2, 3]))
        else:
            setattr(message, name, _SCALARS[text])
    return message
