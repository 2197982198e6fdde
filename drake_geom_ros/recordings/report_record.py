"""``report.json``: what a report was made of, lest it be taken for one of something else."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

from drake_geom_ros.batch.worker import version
from drake_geom_ros.common.whole_files import whole_file

RECORD = 'report.json'
_EVERYWHERE = ('.',)  # the sources of all rooms decide what stands in a report
_BYTES = 1 << 20  # that are read at once


def made_of(
    inputs: Iterable[Path], options: Mapping[str, Any], scenes: Sequence[str]
) -> dict[str, Any]:
    """Return what a report is made of: the version, digests of files and scenes, and options."""
    asked = {
        'version': version(_EVERYWHERE),
        'inputs': {str(path): digest(path) for path in inputs},
        'scenes': list(scenes),
        'options': dict(options),
    }
    found: dict[str, Any] = json.loads(json.dumps(asked))  # as it is read again
    return found


def code_of(folder: Path, asked: Mapping[str, Any]) -> int | None:
    """Return the exit code of the report in a folder; None where it is not there or of others."""
    try:
        record = json.loads((folder / RECORD).read_text(encoding='utf-8'))
        if {name: record[name] for name in asked} != asked:
            return None
        later = record['named_later']
        if later is None or any(digest(Path(path)) != told for path, told in later.items()):
            return None
        is_there = all((folder / name).is_file() for name in record['files'])
        return int(record['exit_code']) if is_there else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def forget(folder: Path) -> None:
    """Remove the record of a report that is about to be written over."""
    (folder / RECORD).unlink(missing_ok=True)


def write_record(
    folder: Path,
    asked: Mapping[str, Any],
    exit_code: int,
    written: Iterable[Path],
    later: Mapping[str, str] | None,
) -> Path:
    """Write what the report in a folder was made of, and its files; return the record.

    ``later`` are digests of files that the recording named; None: it named some in vain, so that
    another time there may be more to tell.
    """
    files = sorted(path.name for path in written)
    named = None if later is None else dict(later)
    record = {**asked, 'named_later': named, 'exit_code': exit_code, 'files': files}
    with whole_file(folder / RECORD) as file:
        json.dump(record, file, indent=1)
    return folder / RECORD


def digest(path: Path) -> str:
    """Return the digest of a file."""
    found = sha256()
    with path.open('rb') as file:
        while part := file.read(_BYTES):
            found.update(part)
    return found.hexdigest()
