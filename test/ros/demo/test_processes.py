import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace as Plain

import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.ros.demo import processes as module
from drake_geom_ros.ros.demo.processes import ProcessFailedError, ProcessGroup, ros_environment

pytestmark = pytest.mark.processes


@pytest.fixture
def modules(tmp_path):
    """Modules that the children run: waits forever, ends at once, fails."""
    (tmp_path / 'waits.py').write_text(
        'import os, pathlib, sys, time\n'
        'pathlib.Path(sys.argv[1]).write_text(str(os.getpid()))\n'
        'print("waiting", flush=True)\n'
        'time.sleep(600)\n'
    )
    (tmp_path / 'ends.py').write_text('print("done")\n')
    (tmp_path / 'fails.py').write_text('raise SystemExit("out of paper")\n')
    (tmp_path / 'finishes.py').write_text(
        'import pathlib, signal, sys, time\n'
        'def finish(*_):\n'
        '    pathlib.Path(sys.argv[1]).write_text("finished")\n'
        '    sys.exit(0)\n'
        'signal.signal(signal.SIGINT, finish)\n'
        'pathlib.Path(sys.argv[2]).write_text("ready")\n'
        'time.sleep(600)\n'
    )
    return {**os.environ, 'PYTHONPATH': str(tmp_path)}


def _wait_for_file(path):
    deadline = time.monotonic() + 60.0
    while not (path.exists() and path.read_text()):
        assert time.monotonic() < deadline, f'{path} did not come'
        time.sleep(0.01)
    return path.read_text()


def _runs(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def _status(pid):
    """Return what the kernel says of a process; who adopts orphans may leave them zombies."""
    try:
        return Path(f'/proc/{pid}/status').read_text()
    except (FileNotFoundError, ProcessLookupError):
        return 'zombie'


def test_others_are_ended_by_pid_when_the_last_is_done(modules, tmp_path):
    with ProcessGroup(modules) as processes:
        processes.start('node', 'waits', str(tmp_path / 'pid'), log=tmp_path / 'node.log')
        pid = int(_wait_for_file(tmp_path / 'pid'))
        processes.start('client', 'ends', log=tmp_path / 'client.log')
        processes.wait_for('client')
        assert _runs(pid)
    assert not _runs(pid)
    assert (tmp_path / 'client.log').read_text() == 'done\n'


def test_a_failure_is_told_with_the_end_of_its_log(modules, tmp_path):
    with ProcessGroup(modules) as processes:
        processes.start('client', 'fails', log=tmp_path / 'client.log')
        with pytest.raises(ProcessFailedError, match=r'client \(pid \d+\) ended with exit code 1'):
            processes.wait_for('client')
    with ProcessGroup(modules) as processes:
        processes.start('client', 'fails', log=tmp_path / 'client.log')
        with pytest.raises(ProcessFailedError, match='out of paper'):
            processes.wait_for('client')


def test_another_process_that_ends_first_is_a_failure(modules, tmp_path):
    with ProcessGroup(modules) as processes:
        processes.start('client', 'waits', str(tmp_path / 'pid'), log=tmp_path / 'client.log')
        pid = int(_wait_for_file(tmp_path / 'pid'))
        processes.start('node', 'ends', log=tmp_path / 'node.log')
        with pytest.raises(ProcessFailedError, match=r'node .*exit code 0'):
            processes.wait_for('client')
    assert not _runs(pid)


def test_an_interrupt_lets_the_client_finish(modules, tmp_path, monkeypatch):
    with ProcessGroup(modules) as processes:
        arguments = str(tmp_path / 'finished'), str(tmp_path / 'ready')
        processes.start('client', 'finishes', *arguments, log=tmp_path / 'client.log')
        _wait_for_file(tmp_path / 'ready')
        interrupts = iter([signal.SIGINT])

        def interrupted(seconds):  # while it waits: anywhere else pytest would end
            for number in interrupts:
                signal.raise_signal(number)

        monkeypatch.setattr(module, 'time', Plain(sleep=interrupted))
        processes.wait_for('client')
    assert (tmp_path / 'finished').read_text() == 'finished'


def test_a_parent_that_is_killed_takes_its_processes_along(modules, tmp_path):
    (tmp_path / 'parent.py').write_text(
        'import os, pathlib, sys, time\n'
        'from drake_geom_ros.ros.demo.processes import ProcessGroup\n'
        'folder = pathlib.Path(sys.argv[1])\n'
        'with ProcessGroup(dict(os.environ)) as processes:\n'
        '    for name in ("node", "client"):\n'
        '        log = folder / f"{name}.log"\n'
        '        processes.start(name, "waits", str(folder / name), log=log)\n'
        '    time.sleep(600)\n'
    )
    paths = [modules['PYTHONPATH'], str(ROOT), os.environ.get('PYTHONPATH', '')]
    environment = {**modules, 'PYTHONPATH': os.pathsep.join(paths)}
    command = [sys.executable, '-m', 'parent', str(tmp_path)]
    parent = subprocess.Popen(command, env=environment)
    pids = [int(_wait_for_file(tmp_path / name)) for name in ('node', 'client')]
    parent.kill()
    parent.wait()
    deadline = time.monotonic() + 60.0
    while any(_runs(pid) and 'zombie' not in _status(pid) for pid in pids):
        assert time.monotonic() < deadline, 'they outlive their parent'
        time.sleep(0.01)


def test_ros_finds_only_this_machine_in_a_domain_of_its_own(monkeypatch):
    for name in ('ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE'):
        monkeypatch.delenv(name, raising=False)
    environment = ros_environment()
    assert environment['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'
    assert 1 <= int(environment['ROS_DOMAIN_ID']) <= 101
    monkeypatch.setenv('ROS_DOMAIN_ID', '42')
    assert ros_environment()['ROS_DOMAIN_ID'] == '42'
