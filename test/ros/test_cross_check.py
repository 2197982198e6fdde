"""A node with a second opinion: right and wrong answers, a peer that dies, and one that hangs."""

import os
from pathlib import Path

import pytest
import rclpy
from cross_check.test_asker import FAULTS, FCL
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from drake_geom_msgs import msg
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import SetParameters
from ros.harness import ROOT, Process
from ros.scene_calls import poses

from drake_geom_ros.command_line.program import main
from drake_geom_ros.cross_check.second_opinion import MOST_LOST
from drake_geom_ros.replay import read

pytestmark = [pytest.mark.topics, pytest.mark.everything]

# [s] of a busy machine, on which the kernels are compiled first.
LONG = 250.0
# What hangs is given up by a timer of 2 s of processor time, three times a pair: set forward here.
HANG = 'import signal; signal.setitimer(signal.ITIMER_PROF, 0.05)\n    while True: pass'
PARAMETERS = {'scene_file': ROOT / 'scenes/minimal.yaml', 'max_distance': 1.0, 'cross_check': 50.0}


@pytest.fixture
def start(tmp_path, monkeypatch, lone_client):
    """Return a function that starts a node, and what feeds it until a fact holds."""
    nodes = []

    def make(started=ROOT / 'scripts/scene_graph_node', paths=(), **parameters):
        joined = [*map(str, paths), os.environ.get('PYTHONPATH', '')]
        monkeypatch.setenv('PYTHONPATH', os.pathsep.join(joined))
        given = {**PARAMETERS, **parameters}
        arguments = [part for name, value in given.items() for part in ('-p', f'{name}:={value}')]
        nodes.append(Process(tmp_path / 'log', started, '--ros-args', *arguments))
        return nodes[-1], Fed(lone_client)

    yield make
    for node in nodes:
        assert node.end() == 0, node.output()


class Fed:
    """Feeds poses to a node, reads its results and its diagnostics."""

    def __init__(self, client):
        self._client, self._count = client, 0
        self.results = client.listen(msg.SignedDistancePairs, 'signed_distances')
        self.diagnostics = client.listen(DiagnosticArray, '/diagnostics')
        self._publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def until(self, fact, what):
        """Publish poses until a fact about the diagnostics holds; return their status."""

        def holds():
            self._count += 1
            x = 0.3 + 0.01 * (self._count % 50)
            self._publisher.publish(poses(['ball'], [(x, 0, 0.05 + 0.2 * (self._count % 2))]))
            return self.diagnostics and fact(self.values())

        self._client.wait_for(holds, what, patience=LONG)
        return self.diagnostics[-1].status[0]

    def values(self):
        """Return what the latest diagnostics say of the cross-check, in numbers."""
        pairs = {value.key: value.value for value in self.diagnostics[-1].status[0].values}
        return {
            key.removeprefix('cross_check '): int(value)
            for key, value in pairs.items()
            if key.startswith('cross_check ')
        }


def test_right_answers_are_agreed_about(start, lone_client):
    node, fed = start()
    status = fed.until(lambda values: values.get('pairs', 0) >= 100, '100 pairs')
    values = fed.values()
    assert {key: values[key] for key in ('disagreements', 'refuted', 'silent', 'lost')} == {
        'disagreements': 0,
        'refuted': 0,
        'silent': 0,
        'lost': 0,
    }
    assert 'disagrees' not in status.message
    assert 'disagrees' not in node.output()
    # It ends, and begins again, while the node runs.
    for rate, there in ((0.0, False), (20.0, True)):
        put(lone_client, rate)
        del fed.diagnostics[:]
        fed.until(lambda values, there=there: bool(values) == there, f'cross_check {rate}')


def put(client, rate):
    """Set the parameter."""
    parameter = rclpy.parameter.Parameter('cross_check', value=rate).to_parameter_msg()
    assert parameter.value.type == ParameterType.PARAMETER_DOUBLE
    (result,) = client.call(SetParameters, 'set_parameters', parameters=[parameter]).results
    assert result.successful, result.reason


def test_wrong_answers_are_counted_told_once_and_kept(start, tmp_path, capsys):
    folder = tmp_path / 'replays'
    node, fed = start('wrong_node', [Path(__file__).parent / 'outputs'], replay_dir=folder)
    status = fed.until(lambda values: values.get('disagreements', 0) >= 10, 'disagreements')
    assert status.level == DiagnosticStatus.WARN
    assert 'python-fcl disagrees with' in status.message
    fed.until(lambda values: node.output().count('python-fcl disagrees about') == 2, 'two lines')
    kinds = {path.name.rpartition('_')[0]: path for path in folder.iterdir()}
    assert sorted(kinds) == ['replay_box_sphere', 'replay_halfspace_sphere']
    replay = read(kinds['replay_box_sphere'])
    # Of the record the distance is right: offline the two agree.
    assert replay.opinion.distance == pytest.approx(replay.answer.distance, abs=1e-6)
    assert main(['replay', str(kinds['replay_box_sphere'])]) == 0
    assert 'it agrees with python-fcl 0.7' in capsys.readouterr().out
    assert node.output().count('python-fcl disagrees about') == 2


@pytest.mark.timeout(600)
@pytest.mark.parametrize('fault', [FAULTS['dies'], HANG], ids=['dies', 'hangs'])
def test_a_peer_that_dies_or_hangs_is_lost_and_the_node_goes_on(start, tmp_path, fault):
    (tmp_path / 'fcl.py').write_text(FCL.format(fault=fault))
    _, fed = start(paths=[tmp_path])
    fed.until(lambda values: values.get('lost', 0) >= 2, 'two lost processes')
    fed.until(lambda values: values['silent'] > 0, 'pairs that are asked about no more')
    assert fed.values()['lost'] >= MOST_LOST
    before = len(fed.results)
    fed.until(lambda values: len(fed.results) > before, 'results, as before')
    assert fed.values()['disagreements'] == 0
