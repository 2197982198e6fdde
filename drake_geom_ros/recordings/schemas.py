"""Support for MCAP files with schemas that are not of ROS 2, which rosbags refuses.

A bridge writes ``protobuf`` or ``jsonschema`` beside ROS topics, and ``ros2 bag record`` writes
``unknown`` with an empty text if it cannot find a definition. Other topics remain readable.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

DEFINED = ('ros2msg', 'ros2idl', 'omgidl')  # encodings of schemas as text
_patching = threading.Lock()


class _NoText(str):
    """Placeholder text for bytes that are not UTF-8."""

    __slots__ = ('error',)
    error: UnicodeDecodeError


@contextmanager
def any_schema() -> Iterator[None]:
    """Let rosbags open MCAP files with any schema within the context.

    A schema of another encoding becomes a definition without a format, whose text is the name of
    the encoding. Other bytes that are not UTF-8 raise UnicodeDecodeError as before. rosbags has
    no option for this, so its functions are replaced while a file is opened.
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
    """Open a recording by rosbags, which raises many kinds of exceptions for invalid files."""
    from rosbags.rosbag2 import Reader

    reader = Reader(path)
    with any_schema():
        reader.open()
    try:
        yield reader
    finally:
        reader.close()


def _check(fields: Any) -> None:
    """Raise UnicodeDecodeError if a field that has to be a text is not UTF-8."""
    for field in fields:
        if isinstance(field, _NoText):
            raise field.error
