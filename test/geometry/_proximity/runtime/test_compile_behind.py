"""A child of low priority that compiles for this CPU: one at a time, once, and only on demand."""

import fcntl
import os
import time
from pathlib import Path

import pytest

from drake_geom_ros.geometry._proximity.runtime import compile_behind
from drake_geom_ros.geometry._proximity.runtime.compile_behind import Mode

pytestmark = pytest.mark.processes

MACHINE = ('x86_64-unknown-linux-gnu', 'znver4', '+avx2')
# In place of compiling: waits for a file that releases it.
CODE = """
import os, sys, time
folder = os.path.dirname(sys.argv[2])
with open(f'{folder}/started', 'a') as file:
    file.write(f'{os.getpid()} {os.getpriority(os.PRIO_PROCESS, 0)} ')
    file.write(os.environ['DRAKE_GEOM_ROS_COMPILE'] + '\\n')
while not os.path.exists(f'{folder}/release'):
    time.sleep(0.01)
open(sys.argv[2], 'w').close()
"""


@pytest.fixture
def ask(tmp_path, monkeypatch):
    """Return a function that asks for the child, as a new process would."""
    monkeypatch.setattr(compile_behind, '_CODE', CODE)
    monkeypatch.delenv(compile_behind.VARIABLE, raising=False)

    def ask(value='', folder=str(tmp_path)):
        monkeypatch.setenv(compile_behind.VARIABLE, value)
        compile_behind.mode.cache_clear()
        compile_behind.compile_behind.cache_clear()
        compile_behind.compile_behind(folder, MACHINE)

    yield ask
    (tmp_path / 'release').touch()
    compile_behind.mode.cache_clear()


def wait_for(fact):
    end = time.monotonic() + 60.0
    while not fact():
        assert time.monotonic() < end
        time.sleep(0.01)


def lines(path):
    return path.read_text().splitlines() if path.exists() else []


def is_free(folder):
    """Return whether no child holds the lock."""
    with open(folder / 'behind.lock', 'w') as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True


def test_one_child_of_low_priority_compiles_for_this_cpu_once(ask, tmp_path, capsys):
    ask()
    (line,) = capsys.readouterr().err.splitlines()
    assert 'DRAKE_GEOM_ROS_COMPILE=never' in line
    wait_for(lambda: lines(tmp_path / 'started'))
    ask('behind')  # another process, while the child is at work
    (tmp_path / 'release').touch()
    wait_for(lambda: is_free(tmp_path))
    ask()  # and when it was done
    ((pid, _, value),) = [each.split() for each in lines(tmp_path / 'started')]
    assert value == Mode.FIRST.value
    assert f'process {pid} ' in line
    assert capsys.readouterr().err == ''


def test_the_child_gives_way_to_all_others(ask, tmp_path):
    ask()
    wait_for(lambda: lines(tmp_path / 'started'))
    pid = int(lines(tmp_path / 'started')[0].split()[0])
    assert os.getpriority(os.PRIO_PROCESS, pid) == 19
    assert os.getsid(pid) == pid  # so that the end of a terminal does not end it


def test_a_child_that_was_killed_is_followed_by_another(ask, tmp_path):
    ask()
    wait_for(lambda: lines(tmp_path / 'started'))
    os.kill(int(lines(tmp_path / 'started')[0].split()[0]), 9)
    wait_for(lambda: is_free(tmp_path))
    ask()
    wait_for(lambda: len(lines(tmp_path / 'started')) == 2)


@pytest.mark.parametrize(('value', 'has_folder'), [('never', True), ('first', True), ('', False)])
def test_no_child_is_started_where_none_is_wanted_or_could_keep_anything(
    ask, tmp_path, capsys, value, has_folder
):
    ask(value, str(tmp_path) if has_folder else '')
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr().err == ''


def test_a_folder_in_which_nothing_can_be_written_is_no_obstacle(ask, tmp_path):
    ask(folder=str(tmp_path / 'missing'))
    assert list(tmp_path.iterdir()) == []


def test_a_value_that_is_none_is_reported_with_those_that_are(ask, tmp_path, capsys):
    (tmp_path / 'release').touch()
    ask('later')
    error = capsys.readouterr().err
    assert "DRAKE_GEOM_ROS_COMPILE is 'later', not one of never, behind, first" in error
    wait_for(lambda: Path(tmp_path / 'started').exists())
    wait_for(lambda: is_free(tmp_path))
