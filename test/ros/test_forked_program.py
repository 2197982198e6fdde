"""A forked program answers to signals and ends as one that is started anew."""

import os
import signal
import subprocess
from pathlib import Path

import pytest
from conventions.source_tree import ROOT
from ros.harness import PATIENCE, Process, environment, run_python, start_node, wait_until_ready

pytestmark = pytest.mark.processes

SCRIPT = ROOT / 'scripts/scene_graph_node'
# The process ends without ending the node, as one that is killed.
DESERTER = """
import os, sys
from pathlib import Path
from ros.harness import Client, start_node, wait_until_ready
node = start_node(Path(sys.argv[1]))
wait_until_ready(Client())
print(node.popen.pid, flush=True)
os._exit(0)
"""


@pytest.mark.parametrize('arguments', [('nonsense',), ('--ros-args', '-p', 'rate:=-1.0')])
def test_a_refusal_has_the_words_and_the_code_of_a_real_start(tmp_path, arguments):
    forked = Process(tmp_path / 'forked', SCRIPT, *arguments)
    anew = Process(tmp_path / 'anew', SCRIPT, *arguments, anew=True)
    assert isinstance(anew.popen, subprocess.Popen)
    assert not isinstance(forked.popen, subprocess.Popen)
    assert forked.popen.wait(PATIENCE) == anew.popen.wait(PATIENCE) == 2
    assert forked.output() == anew.output()
    assert arguments[-1].split(':=')[0] in forked.output()


def test_a_program_that_runs_has_no_exit_code_and_a_killed_one_has_its_signal(tmp_path):
    node = start_node(tmp_path / 'log')
    assert node.popen.poll() is None
    with pytest.raises(subprocess.TimeoutExpired):
        node.popen.wait(0.0)
    assert node.end(signal.SIGKILL) == -signal.SIGKILL == node.popen.poll()
    node.popen.send_signal(signal.SIGKILL)  # nobody
    with pytest.raises(ProcessLookupError):
        os.kill(node.popen.pid, 0)


def test_it_has_the_environment_of_its_start(tmp_path, monkeypatch, lone_client):
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'logs'))
    node = start_node(tmp_path / 'log')
    wait_until_ready(lone_client)
    assert node.end() == 0, node.output()
    assert list((tmp_path / 'logs').iterdir())


def test_it_ends_with_the_process_that_started_it(tmp_path, monkeypatch, lone_client):
    monkeypatch.setenv('PYTHONPATH', f'{environment()["PYTHONPATH"]}{os.pathsep}{ROOT / "test"}')
    done = run_python('-c', DESERTER, tmp_path / 'log', timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    gone = Path(f'/proc/{int(done.stdout)}')
    lone_client.wait_for(lambda: not gone.exists(), 'the node to end')
