"""The process of sensors is started, watched and started again, and outlives nobody."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace as Plain

import pytest

from drake_geom_ros.ros.sensing import process as tested
from drake_geom_ros.ros.sensing.process import SensingProcess
from drake_geom_ros.ros.sensing.protocol import MissedMessages, Task

pytestmark = pytest.mark.processes

PATIENCE = 60.0  # [s]
IDLE = Task('sensors', '/', '/', ())
# Each is run in place of the process, with the number of its pipe.
BROKEN = {
    'noise': ('os.write(pipe, b"\\xff" * 64); time.sleep(100)', 'nobody can read'),
    'a pickle of ours that is no message': (
        'Connection(pipe).send([1, 2]); time.sleep(100)',
        'nobody can read',
    ),
    'a pickle of what is not there': (
        'Connection(pipe).send_bytes(b"cnowhere\\nnothing\\n."); time.sleep(100)',
        'nobody can read',
    ),
    'nothing': ('sys.exit(3)', 'with code 3'),
    'nothing, and dies': ('os.kill(os.getpid(), 11)', 'by SIGSEGV'),
}


class Heard:
    """Keeps what is told."""

    def __init__(self):
        self.told, self.refusals = [], []

    def refused(self, name, reason):
        self.refusals.append((name, reason))

    def tell(self, about, what):
        self.told.append(what)


def wait_for(fact, what, meanwhile=lambda: None):
    end = time.monotonic() + PATIENCE
    while not fact():
        assert time.monotonic() < end, what
        meanwhile()
        time.sleep(0.02)


def pid_of(sensing):
    return int(sensing.in_words().split()[1].rstrip(','))


def is_there(pid):
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except FileNotFoundError:
        return False


@pytest.fixture
def heard():
    return Heard()


@pytest.fixture
def sensing(heard):
    made = SensingProcess(IDLE, {}, heard)
    wait_for(lambda: not made.trouble, 'that it has started')
    yield made
    made.close()


def test_one_that_is_killed_is_told_of_and_another_is_started(sensing, heard):
    first = pid_of(sensing)
    os.kill(first, signal.SIGKILL)
    wait_for(lambda: heard.told, 'trouble')
    (told,) = heard.told
    assert 'ended by SIGKILL' in told
    wait_for(lambda: not sensing.trouble, 'that another one has started')
    assert (sensing.starts, pid_of(sensing) != first) == (2, True)


def test_one_that_hangs_is_ended(sensing, heard, monkeypatch):
    monkeypatch.setattr(tested, '_SILENCE', 1.0)
    wait_for(lambda: sensing._limit == 1.0, 'a sign of life')
    hanging = pid_of(sensing)
    os.kill(hanging, signal.SIGSTOP)
    wait_for(lambda: heard.told, 'trouble', sensing.look)
    assert 'said nothing for 1 s' in heard.told[0]
    assert not is_there(hanging)


def test_one_that_works_is_let_alone(sensing, heard):
    first = pid_of(sensing)
    for _ in range(20):
        sensing.look()
        time.sleep(0.05)
    assert (pid_of(sensing), sensing.starts, heard.told) == (first, 1, [])
    assert 'MB' in sensing.in_words()


def test_closed_it_is_gone_and_stays_so(heard):
    sensing = SensingProcess(IDLE, {}, heard)
    wait_for(lambda: not sensing.trouble, 'that it has started')
    pid = pid_of(sensing)
    sensing.close()
    sensing.close()
    assert not is_there(pid)
    assert (sensing.starts, heard.told) == (1, [])


def test_closed_at_once_nothing_is_left(heard):
    sensing = SensingProcess(IDLE, {}, heard)
    sensing.close()
    assert sensing.in_words().startswith('none runs')
    assert heard.told == []


@pytest.mark.parametrize('name', BROKEN)
def test_one_that_makes_no_sense_is_ended_and_not_started_over_and_over(
    name, heard, monkeypatch, tmp_path
):
    code, reason = BROKEN[name]
    head = 'import os, sys, time\nfrom multiprocessing.connection import Connection\n'
    (tmp_path / 'broken_sensing.py').write_text(f'{head}pipe = int(sys.argv[1])\n{code}\n')
    monkeypatch.setenv('PYTHONPATH', f'{tmp_path}:{os.environ.get("PYTHONPATH", "")}')
    monkeypatch.setattr(tested, '_MODULE', 'broken_sensing')
    monkeypatch.setattr(tested, '_FIRST_PAUSE', 1000.0)
    sensing = SensingProcess(IDLE, {}, heard)
    wait_for(lambda: heard.told, 'trouble', sensing.look)
    assert reason in heard.told[0]
    assert reason in sensing.trouble
    wait_for(lambda: sensing.in_words().startswith('none runs'), 'its end')
    sensing.close()  # in the midst of the pause
    assert sensing.starts == 1


def test_it_ends_with_who_started_it_however_that_dies():
    script = (
        'import time\n'
        'from drake_geom_ros.ros.sensing.process import SensingProcess\n'
        'from drake_geom_ros.ros.sensing.protocol import Task\n'
        'class Heard:\n'
        '    def tell(self, about, what): pass\n'
        'sensing = SensingProcess(Task("sensors", "/", "/", ()), {}, Heard())\n'
        'while sensing.trouble: time.sleep(0.02)\n'
        'print(sensing.in_words(), flush=True)\n'
        'time.sleep(100)\n'
    )
    command = [sys.executable, '-c', script]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as other:
        pid = int(other.stdout.readline().split()[1].rstrip(','))
        assert is_there(pid)
        other.kill()
    wait_for(lambda: not is_there(pid), 'the end of what it started')


# In place of the process: it says that it compiles, for longer than it may be silent.
COMPILES = """\
from multiprocessing.connection import Connection
import sys, time
from drake_geom_ros.ros.sensing.protocol import ALIVE, COMPILING
pipe = Connection(int(sys.argv[1]))
pipe.recv()
for _ in range(30):
    pipe.send(COMPILING)
    time.sleep(0.1)
while True:
    pipe.send(ALIVE)
    pipe.recv()
    time.sleep(0.1)
"""


def test_one_that_compiles_for_long_is_let_alone(heard, monkeypatch, tmp_path):
    (tmp_path / 'compiling_sensing.py').write_text(COMPILES)
    monkeypatch.setenv('PYTHONPATH', f'{tmp_path}:{os.environ.get("PYTHONPATH", "")}')
    monkeypatch.setattr(tested, '_MODULE', 'compiling_sensing')
    sensing, signs = SensingProcess(IDLE, {}, heard), set()

    def works():
        if sensing.trouble:  # what takes nothing yet is in trouble
            signs.add(sensing._heard)
        return not sensing.trouble

    wait_for(works, 'its work', sensing.look)
    assert len(signs) > 3
    assert (sensing.starts, heard.told) == (1, [])
    sensing.close()


def test_messages_that_it_never_had_are_counted_for_their_map(sensing):
    missed = []
    sensing.listen_to((), {'scan': Plain(miss=missed.append)})
    for name in ('scan', 'removed', 'scan'):
        sensing._answer(None, MissedMessages(name, len(missed) + 2))
    assert missed == [2, 3]
