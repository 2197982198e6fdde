"""Command ``replay``: reproduce the query of a replay file, or recorded rule events."""

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from drake_geom_ros.command_line.exit_codes import DONE, NO
from drake_geom_ros.replay import (
    Answer,
    Finding,
    Judge,
    Opinion,
    Replay,
    read,
    read_events,
    reproduce,
)


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'replay',
        description='Rebuilds the scene of a replay file (parameter replay_dir of the node), asks '
        'for the pair again and compares. Exit code 1 where the answer still '
        'exceeds its tolerance, or still differs from the other opinion in the file. With '
        '--scene FILE is a recording of ~/proximity_events: each decision is computed again '
        'from the poses in it. Exit code 1 where one was unfounded, or is missing.',
    )
    parser.add_argument('file', metavar='FILE', help='written by the node, or recorded')
    parser.add_argument(
        '--scene',
        metavar='SCENE',
        help='the scene of the events in FILE, as save_scene wrote it at their scene_version',
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Reproduce, compare, and return the exit code; raises GeometryError or OSError."""
    if options.scene is not None:
        return _judge(options.file, Path(options.scene))
    replay = read(options.file)
    now = reproduce(replay, options.file)
    for line in _report(replay, now):
        print(line)
    differs = replay.opinion is not None and replay.opinion.differs(now)
    return NO if now.breaks_promise or differs else DONE


def _judge(file: str, scene: Path) -> int:
    """Print the verdict on each recorded event; return the exit code."""
    judge, verdicts, missing, last = Judge(scene), Counter[Finding](), 0, 0
    for event in read_events(file):
        if 0 < last < event.sequence - 1:
            missing += event.sequence - 1 - last
            print(f'MISSING: events {last + 1} to {event.sequence - 1}')
        elif event.sequence <= last:
            print(
                f'event {event.sequence} follows {last}: a node began anew, or it is there twice'
            )
        last = event.sequence
        verdict = judge.verdict(event)
        verdicts[verdict.finding] += 1
        verb = 'entered' if event.entered else 'left'
        print(f'{event.sequence} {event.rule}: {verb}, {event.why.name.lower()}: '
              f'{verdict.finding.value}: {verdict.because}')  # fmt: skip
        if event.has_pair:
            print(f'    {event.geometry_a} to {event.geometry_b}')
        for title, then, now in (
            ('distance', event.distance, verdict.distance),
            ('error bound', event.error_bound, verdict.error_bound),
        ):
            if now is not None:
                print(f'    {title} [m]: recorded {then!r}, now {now!r}')
    counts = [f'{verdicts[finding]} {finding.value}' for finding in Finding]
    print(', '.join([*counts, f'{missing} MISSING'] if missing else counts))
    return NO if verdicts[Finding.UNFOUNDED] or missing else 0


def _report(replay: Replay, now: Answer) -> Iterator[str]:
    question = replay.question
    for name in (question.geometry_a, question.geometry_b):
        source, frame, geometry = name
        yield f'{source}::{frame}/{geometry}'
    start = 'the hint of the file' if question.hint else 'no hint'
    yield f'accuracy {question.accuracy}, pairs within {question.max_distance:g} m, {start}'
    yield f'recorded with {", ".join(f"{name} {text}" for name, text in replay.versions.items())}'
    yield f'{"":26}{"recorded":>26}{"now":>26}'
    for title, then, new in _rows(replay.answer, now):
        yield f'{title:26}{then:>26}{new:>26}'
    yield _verdict(now)
    if replay.opinion is not None:
        yield _second(replay.opinion, now)


def _rows(then: Answer, now: Answer) -> Iterator[tuple[str, str, str]]:
    """Yield title, recorded and new value, with all digits."""
    numbers = ('distance', 'error_bound', 'promised_error_bound')
    for name in numbers:
        yield f'{name} [m]', repr(getattr(then, name)), repr(getattr(now, name))
    for name in ('nhat_BA_W', 'p_ACa', 'p_BCb'):
        for axis, x, y in zip('xyz', getattr(then, name), getattr(now, name), strict=True):
            yield f'{name} {axis}', repr(x), repr(y)
    yield 'method', then.method, now.method


def _verdict(now: Answer) -> str:
    bounds = f'error bound {now.error_bound:.3g} m, allowed {now.promised_error_bound:.3g} m'
    if now.breaks_promise:
        return f'the answer still exceeds its tolerance: {bounds}'
    return f'the answer meets its tolerance: {bounds}'


def _second(opinion: Opinion, now: Answer) -> str:
    """Return one line on whether the answer still differs from the other library's."""
    answer = 'no contact' if opinion.distance is None else f'{opinion.distance!r} m'
    verb = 'still differs from' if opinion.differs(now) else 'agrees with'
    return f'it {verb} {opinion.library}: {answer} within {opinion.tolerance:.3g} m'
