"""The node's side: a process that is asked, is lost, and is started again."""

import os
import signal
import subprocess
import sys
import textwrap
from types import SimpleNamespace as Plain

import pytest
from cross_check.test_second_opinion import asked  # noqa: F401  (a fixture)

from drake_geom_ros.cross_check import asker as asker_module
from drake_geom_ros.cross_check.asker import Asker, missing
from drake_geom_ros.cross_check.question import AGREED, LOST

pytestmark = [pytest.mark.processes, pytest.mark.everything]

# A library that python-fcl is replaced by, which does one thing with every pair.
FCL = """
import os
class Thing:
    def __init__(self, *arguments, **keywords): self.contacts = []
    def setTransform(self, pose): pass
Sphere = Box = Capsule = Convex = Halfspace = Transform = CollisionObject = Thing
DistanceRequest = DistanceResult = CollisionRequest = CollisionResult = Thing
def distance(a, b, request, result):
    {fault}
collide = distance
"""
FAULTS = {'dies': 'os.abort()', 'hangs': 'while True: pass'}


@pytest.fixture
def asker():
    made = Asker(lambda: False)
    yield made
    made.close()


def verdicts(asker, asked):  # noqa: F811
    query, questions = asked
    found = asker.ask(query, 1, questions)
    return found and [each.verdict for each in found]


def test_it_answers_and_answers_again(asker, asked):  # noqa: F811
    for _ in range(2):
        assert verdicts(asker, asked) == [AGREED] * 10
    assert asker.lost == 0


def test_a_process_that_was_killed_is_started_again_after_a_while(
    asker,
    asked,  # noqa: F811
    monkeypatch,
):
    assert verdicts(asker, asked) == [AGREED] * 10
    asker._process.send_signal(signal.SIGKILL)
    asker._process.wait()
    now = [100.0]
    monkeypatch.setattr(asker_module, 'time', Plain(monotonic=lambda: now[0]))
    assert verdicts(asker, asked) is None
    assert asker.lost == 1
    now[0] += asker_module._PAUSE - 1.0
    assert verdicts(asker, asked) is None  # too early, which is no loss
    assert asker.lost == 1
    now[0] += 2.0
    assert verdicts(asker, asked) == [AGREED] * 10


def test_a_process_that_does_not_answer_is_ended(asker, asked, monkeypatch):  # noqa: F811
    assert verdicts(asker, asked) == [AGREED] * 10
    process = asker._process
    process.send_signal(signal.SIGSTOP)
    monkeypatch.setattr(asker_module, '_PATIENCE', 0.5)
    assert verdicts(asker, asked) is None
    assert (asker.lost, process.returncode) == (1, -signal.SIGKILL)


@pytest.mark.parametrize('fault', FAULTS)
def test_a_library_that_dies_or_hangs_costs_verdicts_alone(
    asker,
    asked,  # noqa: F811
    tmp_path,
    monkeypatch,
    fault,
):
    (tmp_path / 'fcl.py').write_text(textwrap.dedent(FCL).format(fault=FAULTS[fault]))
    paths = [str(tmp_path), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))
    query, questions = asked
    found = asker.ask(query, 1, questions[:2])
    assert [each.verdict for each in found] == [LOST, LOST]
    assert asker.lost == 0


def test_who_stops_waits_no_longer(asked):  # noqa: F811
    asker = Asker(lambda: True)
    try:
        assert verdicts(asker, asked) is None
    finally:
        asker.close()
    assert asker.lost == 0


def test_what_is_missing_is_named(monkeypatch):
    assert missing() == []
    monkeypatch.setattr(asker_module, 'find_spec', lambda name: None)
    assert missing() == ['python-fcl']


@pytest.mark.processes
def test_the_side_of_the_node_loads_nothing_that_judges():
    script = (
        'import sys, drake_geom_ros.live.outputs.cross_check\n'
        'judging = "drake_geom_ros.cross_check.judging" in sys.modules\n'
        'print(judging, "fcl" in sys.modules, "mpmath" in sys.modules)'
    )
    done = subprocess.run([sys.executable, '-c', script], capture_output=True, text=True)
    assert done.stdout == 'False False False\n', done.stderr


@pytest.mark.processes
def test_a_node_without_a_second_opinion_loads_nothing_of_it():
    script = (
        'import sys, drake_geom_ros.ros.scene_graph_node\n'
        'print([n for n in sys.modules if "cross_check" in n])'
    )
    done = subprocess.run([sys.executable, '-c', script], capture_output=True, text=True)
    assert done.stdout == '[]\n', done.stderr
