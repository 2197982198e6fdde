"""A question that kills or hangs its process costs one answer, and no other."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from drake_geom_ros.cross_check.lost_process import outcomes

pytestmark = [pytest.mark.processes, pytest.mark.everything]


def ask(question):
    if question == 'abort':
        os.kill(os.getpid(), signal.SIGKILL)
    if question == 'hang':
        while True:
            pass
    if question == 'wait':
        time.sleep(60)
    if question == 'raise':
        raise ValueError('no')
    if question == 'leave':
        os._exit(0)
    return question.upper()


def test_every_question_gets_its_outcome_in_order():
    questions = ['a', 'abort', 'b', 'hang', 'raise', 'leave', 'c', 'abort']
    found = list(outcomes(questions, ask, 1.0))
    assert [question for question, _ in found] == questions
    ends = [outcome.end for _, outcome in found]
    assert ends == ['answer', 'crash', 'answer', 'hang', 'exception', 'crash', 'answer', 'crash']
    assert found[0][1].value == 'A'
    assert found[1][1].value == f'signal {int(signal.SIGKILL)}'
    assert isinstance(found[4][1].value, ValueError)


def test_one_whose_parent_was_killed_ends():
    script = (
        'import os, signal\n'
        'from drake_geom_ros.cross_check.lost_process import LostProcess\n'
        'process = LostProcess(lambda: os.getpid)\n'
        'print(process.ask(5.0).value, flush=True)\n'
        'os.kill(os.getpid(), signal.SIGKILL)\n'
    )
    done = subprocess.run([sys.executable, '-c', script], capture_output=True, text=True)
    pid, end = int(done.stdout), time.monotonic() + 60.0
    while is_running(pid) and time.monotonic() < end:
        time.sleep(0.05)
    assert not is_running(pid)


def is_running(pid):
    """Return whether a process is there that nobody has to bury."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except OSError:
        return False


def test_one_that_waits_hangs_too(monkeypatch):
    monkeypatch.setattr('drake_geom_ros.cross_check.lost_process.PATIENCE', 1.0)
    found = [outcome for _, outcome in outcomes(['wait', 'a'], ask, 1.0)]
    assert found == [('hang', '1 s'), ('answer', 'A')]


def test_an_error_that_cannot_be_sent_is_told_by_its_text():
    class LocalError(Exception):
        pass

    def ask_local(question):
        raise LocalError(f'about {question}')

    ((_, outcome),) = outcomes(['x'], ask_local, 2.0)
    assert (outcome.end, str(outcome.value)) == ('exception', 'about x')
