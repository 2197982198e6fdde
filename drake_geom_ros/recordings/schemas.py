"""Schemas of MCAP that are none of ROS 2: rosbags refuses a file for one, on whatever topic.

A bridge writes ``protobuf`` or ``jsonschema`` beside ROS topics, and ``ros2 bag record`` writes
``unknown`` with an empty text where it cannot find a definition. None of it matters to other
topics.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

DEFINED = ('ros2msg', 'ros2idl', 'omgidl')  # encodings of schemas that are texts
_patching = threading.Lock()


class _NoText(str):
    """Stands for bytes that are no UTF-8."""

    __slots__ = ('error',)
    error: UnicodeDecodeError


@contextmanager
def any_schema() -> Iterator[None]:
    """Have rosbags open MCAP files with any schema.

    A schema of another encoding counts as a definition without a format whose text is the name of
    the encoding. All else that is no UTF-8 raises UnicodeDecodeError as before. rosbags has no
    option for it, so its two functions are replaced while a file is opened.
    """
    from rosbags.interfaces import MessageDefinition, MessageDefinitionFormat
    from rosbags.rosbag2 import storage_mcap

    with _patching:
        read, define, connect = (
            storage_mcap.read_string,
            storage_mcap.get_msgdef,
            storage_mcap.Connection,
        )

        def read_string(file: Any) -> str:
            data: bytes = storage_mcap.read_bytes(file)
            try:
                return data.decode()
            except UnicodeDecodeError as error:
                text = _NoText(data.decode(errors='replace'))  # not '', which has a meaning
                text.error = error
                return text

        def get_msgdef(schema: Any) -> Any:
            if schema is None or not schema.encoding:
                return define(None)
            if schema.encoding in DEFINED:
                _check(schema)
                return define(schema)
            _check((schema.name, schema.encoding))
            return MessageDefinition(MessageDefinitionFormat.NONE, schema.encoding)

        def connection(*fields: Any) -> Any:
            _check(fields)
            return connect(*fields)

        storage_mcap.read_string, storage_mcap.get_msgdef = read_string, get_msgdef
        storage_mcap.Connection = connection
        try:
            yield
        finally:
            storage_mcap.read_string, storage_mcap.get_msgdef = read, define
            storage_mcap.Connection = connect


@contextmanager
def open_reader(path: Path) -> Iterator[Any]:
    """Open a recording by rosbags; raises exceptions of many kinds for what it cannot read."""
    from rosbags.rosbag2 import Reader

    reader = Reader(path)
    with any_schema():
        reader.open()
    try:
        yield reader
    finally:
        reader.close()


def _check(fields: Any) -> None:
    """Raise UnicodeDecodeError where a field that has to be a text is none."""
    for field in fields:
        if isinstance(field, _NoText):
            raise field.error
