"""Replay files: JSON with the fields of Replay, written atomically.

``replay.schema.json`` defines the format. Numbers have all digits; those that are not finite are
``NaN`` and ``Infinity``, as Python writes them.
"""

from __future__ import annotations

import dataclasses
import json
import os
from pathlib import Path
from typing import Any

from drake_geom_ros.common.whole_files import whole_file
from drake_geom_ros.replay.record import Answer, Opinion, Question, Replay
from drake_geom_ros.scene_files import SceneFileError
from drake_geom_ros.scene_files.schema import faults, read_schema
from drake_geom_ros.scene_files.yaml_text import key_text

_FORMAT = 'drake_geom_ros replay 1'


def write(replay: Replay, path: Path) -> None:
    """Write a new replay file; raises OSError if the path exists or cannot be written.

    An error leaves no partial file.
    """
    text = json.dumps({'format': _FORMAT, **dataclasses.asdict(replay)}, indent=1) + '\n'
    if os.path.lexists(path):
        raise FileExistsError(f'{path} is there already, and stays as it is')
    with whole_file(path) as file:
        file.write(text)


def read(path: str | Path) -> Replay:
    """Return the contents of a replay file; raises SceneFileError for other files, OSError."""
    file = str(path)
    try:
        data = json.loads(Path(path).read_text(encoding='utf-8'))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise SceneFileError(f'not JSON: {error}', file) from None
    if not isinstance(data, dict) or data.pop('format', None) != _FORMAT:
        raise SceneFileError(f'not a replay file: format must be {_FORMAT!r}', file)
    for where, reason in faults(data, read_schema('drake_geom_ros.replay', 'replay.schema.json')):
        raise SceneFileError(reason, file, key=key_text(where))
    question, answer = Question(**_record(data['question'])), Answer(**_record(data['answer']))
    plain = data.get('opinion')
    opinion = None if plain is None else Opinion(**_record(plain))
    records = {'question': question, 'answer': answer, 'opinion': opinion}
    return Replay(**_record({**data, **records}))


def _record(data: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a record, with tuples for JSON's lists."""
    return {key: tuple(value) if isinstance(value, list) else value for key, value in data.items()}
