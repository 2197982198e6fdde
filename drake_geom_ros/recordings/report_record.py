"""File ``report.json``: inputs and options of a report, by which a current one is recognised."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

from drake_geom_ros.batch.worker import version
from drake_geom_ros.common.whole_files import whole_file

RECORD = 'report.json'
_EVERYWHERE = ('.',)  # all sources of the package can change a report
_BYTES = 1 << 20  # read at once


def made_of(
    inputs: Iterable[Path], options: Mapping[str, Any], scenes: Sequence[str]
) -> dict[str, Any]:
    """Return the request of a report: version, digests of inputs and scenes, and options."""
    request = {
        'version': version(_EVERYWHERE),
        'inputs': {str(path): digest(path) for path in inputs},
        'scenes': list(scenes),
        'options': dict(options),
    }
    plain: dict[str, Any] = json.loads(json.dumps(request))  # comparable with what is read back
    return plain


def code_of(folder: Path, request: Mapping[str, Any]) -> int | None:
    """Return the exit code of the report in a folder; None if absent or of another request."""
    try:
        record = json.loads((folder / RECORD).read_text(encoding='utf-8'))
        if {name: record[name] for name in request} != request:
            return None
        later = record['named_later']
        if later is None or any(digest(Path(path)) != before for path, before in later.items()):
            return None
        is_there = all((folder / name).is_file() for name in record['files'])
        return int(record['exit_code']) if is_there else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def forget(folder: Path) -> None:
    """Remove the record of a report that is about to be overwritten."""
    (folder / RECORD).unlink(missing_ok=True)


def write_record(
    folder: Path,
    request: Mapping[str, Any],
    exit_code: int,
    written: Iterable[Path],
    later: Mapping[str, str] | None,
) -> Path:
    """Write the record of a report with its request and files; return its path.

    ``later`` are digests of files that the recording named; None: it named missing ones, so that
    another run may find more.
    """
    files = sorted(path.name for path in written)
    named = None if later is None else dict(later)
    record = {**request, 'named_later': named, 'exit_code': exit_code, 'files': files}
    with whole_file(folder / RECORD) as file:
        json.dump(record, file, indent=1)
    return folder / RECORD


def digest(path: Path) -> str:
    """Return the digest of a file."""
    sha = sha256()
    with path.open('rb') as file:
        while part := file.read(_BYTES):
            sha.update(part)
    return sha.hexdigest()
