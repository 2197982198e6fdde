"""The mutants that change nothing, and why: a list for people to read.

``test/mutants/equivalent.yaml`` maps a file to groups of mutants, each with its reason; a line is
a mutant as ``Mutant.says`` puts it, with ``*`` for whatever becomes of the line::

    drake_geom_ros/geometry/_proximity/kernels/vectors.py:
    - why: at the ends of the range both ways give the same number to the last digit
      mutants: |
        norm: if SMALL_SQUARE < squared < LARGE_SQUARE: ==> if SMALL_SQUARE <= squared < ...
    - why: it sets how long it takes, not what comes of it
      mutants: |
        module: ROOM = 64 ==> *
"""

from __future__ import annotations

from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
LIST = ROOT / 'test/mutants/equivalent.yaml'


def load(path: Path) -> dict[str, dict[str, str]]:
    """Return {file: {mutant: reason}}; a mutant that is listed twice raises ValueError."""
    listed: dict[str, dict[str, str]] = {}
    for file, groups in (yaml.safe_load(path.read_text()) or {}).items():
        reasons = listed.setdefault(file, {})
        for group in groups:
            for line in group['mutants'].splitlines():
                if line in reasons:
                    raise ValueError(f'{path}: {file}: twice: {line}')
                reasons[line] = group['why']
    return listed


def is_listed(reasons: dict[str, str], mutant: str) -> bool:
    """Return whether a mutant of a file is listed, itself or with all of its line."""
    return mutant in reasons or f'{mutant.partition(" ==> ")[0]} ==> *' in reasons


def stale(reasons: dict[str, str], source: str) -> list[str]:
    """Return the listed mutants whose line is not in the source any more."""
    lines = {line.strip() for line in source.splitlines()}
    return [each for each in reasons if each.partition(': ')[2].partition(' ==> ')[0] not in lines]
