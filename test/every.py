"""Tests that loop: each judges many cases and reports all that fail, by name, in one message."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

TESTS = Path(__file__).resolve().parent


def report(offenders: Iterable[str], note: str = '') -> None:
    """Fail with a line for each offender, and a note where one is needed; pass without any."""
    __tracebackhide__ = True
    lines = list(offenders)
    if lines:
        heading = f'{len(lines)} wrong{f" ({note})" if note else ""}:'
        pytest.fail('\n'.join([heading, *lines]))


def check(
    judge: Callable[[Any], object],
    cases: Iterable[Any],
    name: Callable[[Any], str] = str,
    note: str = '',
) -> None:
    """Call a judge, which asserts, with each case; fail with the names of all that fail."""
    __tracebackhide__ = True
    report((f'{name(case)}: {why}' for case in cases if (why := failure(judge, case))), note)


def failure(judge: Callable[[Any], object], case: Any) -> str:
    """Return why a judge fails a case, with the line of the assertion; '' if it passes."""
    try:
        judge(case)
    except (Exception, pytest.fail.Exception) as error:
        frames = traceback.extract_tb(error.__traceback__)
        ours = [frame for frame in frames if TESTS in Path(frame.filename).parents]
        place = (ours or frames)[-1]
        kind = '' if isinstance(error, AssertionError) else f'{type(error).__name__}: '
        text = f'{Path(place.filename).name}:{place.lineno}: {kind}{error}'
        return text.strip().replace('\n', '\n    ')
    return ''
