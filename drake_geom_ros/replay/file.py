"""Replay files: JSON with the fields of Replay, written whole or not at all.

Numbers have all their digits; those that are not finite are ``NaN`` and ``Infinity``, as Python
writes them.
"""

from __future__ import annotations

import dataclasses
import json
import os
import tempfile
from pathlib import Path
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

from drake_geom_ros.replay.record import Replay
from drake_geom_ros.scene_files import SceneFileError

_FORMAT = 'drake_geom_ros replay 1'


def write(replay: Replay, path: Path) -> None:
    """Write a replay file; raises OSError, and leaves no part of a file, where it cannot be."""
    text = json.dumps({'format': _FORMAT, **dataclasses.asdict(replay)}, indent=1) + '\n'
    descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix='.', suffix='.part')
    try:
        with open(descriptor, 'w', encoding='utf-8') as file:
            file.write(text)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def read(path: str | Path) -> Replay:
    """Return what a replay file holds; raises SceneFileError for what is none, OSError."""
    file = str(path)
    try:
        data = json.loads(Path(path).read_text(encoding='utf-8'))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise SceneFileError(f'not JSON: {error}', file) from None
    if not isinstance(data, dict) or data.pop('format', None) != _FORMAT:
        raise SceneFileError(f'no replay file: format must be {_FORMAT!r}', file)
    replay: Replay = _value(data, Replay, '', file)
    return replay


def _value(data: Any, kind: Any, key: str, file: str) -> Any:
    """Return plain ``data`` as a value of a kind that the records have; SceneFileError if not."""
    if dataclasses.is_dataclass(kind):
        return _record(data, kind, key, file)
    if isinstance(kind, UnionType):  # ... | None
        return None if data is None else _value(data, get_args(kind)[0], key, file)
    if get_origin(kind) is tuple:
        items = get_args(kind)
        count = 3 if items[-1] is Ellipsis else len(items)
        if not isinstance(data, list) or len(data) != count:
            raise SceneFileError(f'must be a list of {count}', file, key=key)
        return tuple(_value(item, items[0], f'{key}[{k}]', file) for k, item in enumerate(data))
    if get_origin(kind) is not None:  # a mapping of texts
        if not isinstance(data, dict) or not all(isinstance(v, str) for v in data.values()):
            raise SceneFileError('must be an object of texts', file, key=key)
        return data
    if kind is float and type(data) is int:
        return float(data)
    if type(data) is not kind:
        raise SceneFileError(f'{str(data)[:80]!r} must be of type {kind.__name__}', file, key=key)
    return data


def _record(data: Any, kind: Any, key: str, file: str) -> Any:
    hints = get_type_hints(kind)
    if not isinstance(data, dict) or data.keys() != hints.keys():
        raise SceneFileError(f'must have the keys {", ".join(hints)}', file, key=key)
    fields = {
        name: _value(data[name], hint, f'{key}.{name}'.lstrip('.'), file)
        for name, hint in hints.items()
    }
    return kind(**fields)
