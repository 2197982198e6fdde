"""The node writes replay files of answers that exceed their tolerance."""

import os
from pathlib import Path

import pytest
from drake_geom_msgs import msg
from ros.harness import ROOT, Process
from ros.scene_calls import poses

from drake_geom_ros.command_line.program import main
from drake_geom_ros.replay import read

pytestmark = pytest.mark.topics


def test_the_node_writes_files_that_reproduce(tmp_path, lone_client, monkeypatch, capsys):
    folder = tmp_path / 'replays'
    paths = [str(Path(__file__).parent), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))
    parameters = {'scene_file': ROOT / 'scenes' / 'minimal.yaml', 'max_distance': 1.0}
    parameters |= {'replay_dir': folder, 'replay_limit': 1}
    arguments = [part for name, value in parameters.items() for part in ('-p', f'{name}:={value}')]
    node = Process(tmp_path / 'log', 'narrowed_node', '--ros-args', *arguments)
    try:
        results = lone_client.listen(msg.SignedDistancePairs, 'signed_distances')
        publisher = lone_client.publisher(msg.FramePoses, 'frame_poses')

        def told():
            publisher.publish(poses(['ball'], [(0.5, 0, 0.3)]))
            return 'replay_limit (1 files) is reached' in node.output()

        lone_client.wait_for(told, 'two findings and one file')
        (path,) = folder.iterdir()
        replay = read(path)
        pairs = list(zip(results[0].id_a, results[0].id_b, strict=True))
        assert replay.answer.distance == results[0].distance[pairs.index(replay.ids)]
        assert f'python -m drake_geom_ros replay {path}' in node.output()
    finally:
        assert node.end() == 0
    # Offline the promise is what it is, and kept.
    assert main(['replay', str(path)]) == 0
    assert 'the answer meets its tolerance' in capsys.readouterr().out
