"""Definitions of message types from the installed packages, as recordings hold them."""

from __future__ import annotations

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from drake_geom_ros.scene_files import share_folders


class UnknownTypeError(RuntimeError):
    """The definition of a message type is not installed."""


class Definitions:
    """Reads definitions when a type is first asked for, with all types that it is made of."""

    def __init__(self) -> None:
        self.types: Typestore = get_typestore(Stores.EMPTY)

    def add(self, kind: str) -> Typestore:
        """Return a type store that has ``kind`` (``package/msg/Type``).

        Raises UnknownTypeError where its package, or its file there, is missing.
        """
        waiting = [kind]
        while waiting:
            name = waiting.pop()
            if name in self.types.fielddefs:
                continue
            for found, fields in get_types_from_msg(_text_of(name), name).items():
                self.types.register({found: fields})
                waiting += [each for each in _parts(fields[1]) if each not in self.types.fielddefs]
        return self.types


def _text_of(kind: str) -> str:
    package, _, name = kind.split('/')
    folders = share_folders()
    for folder in folders:
        path = folder / package / 'msg' / f'{name}.msg'
        if path.is_file():
            return path.read_text()
    raise UnknownTypeError(
        f'the type {kind} cannot be recorded: its definition is in none of '
        f'{", ".join(map(str, folders))}'
    )


def _parts(fields: object) -> list[str]:
    """Return the names of message types in the fields of a definition."""
    names: list[str] = []
    if isinstance(fields, (list, tuple)):
        for each in fields:
            names += _parts(each)
    elif isinstance(fields, str) and fields.count('/') == 2:
        names.append(fields)
    return names
