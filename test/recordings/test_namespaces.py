"""Which topics count: those of a namespace, of robots in it, and what is said where none does."""

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import HERE, URDF, balls, poses  # noqa: F401

from drake_geom_ros.command_line.program import main
from drake_geom_ros.recordings import RecordingError, Topics, clearance
from drake_geom_ros.recordings.recorded_poses import recorded_poses

JOINTS = 'turn', 'bend', 'roll', 'slide'
CELL = """
robots:
  - {name: arm, urdf: arm.urdf, joint_states: left/joint_states}
frames: [{name: ball, pose: {position: [3, 0, 0]}}]
geometries: [{name: ball, frame: ball, shape: {type: sphere, radius: 0.1}}]
"""


def joints(topic):
    return [
        (0.1 * k, topic, recorder.joint_state(0.1 * k, JOINTS, [0.1 * k] * 4)) for k in range(20)
    ]


@pytest.fixture
def cell(tmp_path):
    (tmp_path / 'arm.urdf').write_text(URDF)
    file = tmp_path / 'cell.yaml'
    file.write_text(CELL.replace('urdf: arm.urdf', 'urdf: arm.urdf, pose: {}'))
    return file


def test_all_of_a_namespace_is_taken(tmp_path, balls):  # noqa: F811
    edges = [(0.05 + 0.1 * k, recorder.transforms(0.05, ('world', 'a', HERE))) for k in range(20)]
    found = {}
    for space in ('', '/cell_1'):
        told = poses(0.1 * np.arange(20), 'b', [[(1.0, 0, 0, 0, 0, 0, 1)]] * 20, f'{space}/n/p')
        told += [(t, f'{space}/tf', message) for t, message in edges]
        told += [(0.0, '/clock', recorder.clock(recorder.BEGIN / 1e9))]
        run = recorder.record(tmp_path / f'run{len(space)}', sorted(told, key=lambda m: m[0]))
        found[space] = clearance(run, balls, topics=Topics(namespace=space), between=['a:b'])
    one, other = (each['a:b'] for each in found.values())
    np.testing.assert_array_equal(one.known_distance, other.known_distance)
    assert np.isfinite(one.distance).any()


def test_topics_of_robots_are_in_the_namespace(tmp_path, cell):
    run = recorder.record(tmp_path / 'run', joints('/cell_1/left/joint_states'))
    with pytest.raises(RecordingError) as told:
        clearance(run, cell)
    assert '/left/joint_states, which moves a robot, was not recorded' in str(told.value)
    assert '--namespace cell_1' in str(told.value)
    found = clearance(run, cell, topics=Topics(namespace='cell_1'))
    assert np.isfinite(found['all'].distance).all()
    (first, *_) = recorded_poses(run, cell, 10.0, Topics(namespace='cell_1'))
    assert ('arm', 'base') in first.frames


def test_two_nodes_are_told_apart_by_their_namespace(tmp_path, balls):  # noqa: F811
    told = []
    for space, x in (('one', 1.0), ('two', 2.0)):
        rows = [[HERE, (x, 0, 0, 0, 0, 0, 1)]]
        told += poses([0.0], 'ab', rows, f'/{space}/node/frame_poses')
    run = recorder.record(tmp_path / 'run', told)
    with pytest.raises(RecordingError, match='--namespace'):
        clearance(run, balls)
    found = clearance(run, balls, topics=Topics(namespace='two'), between=['a:b'])
    assert found['a:b'].distance[0] == pytest.approx(1.8)
    with pytest.raises(RecordingError, match=r"namespace 'three': no topic.*/one/node"):
        clearance(run, balls, topics=Topics(namespace='three'))


def test_tf_of_everybody_and_of_the_namespace_are_not_mixed(tmp_path, balls):  # noqa: F811
    edges = ('world', 'a', HERE), ('world', 'b', HERE)
    told = [(0.0, topic, recorder.transforms(0.0, *edges)) for topic in ('/tf', '/x/tf')]
    run = recorder.record(tmp_path / 'run', told)
    with pytest.raises(RecordingError, match='both /tf and /x/tf'):
        clearance(run, balls, topics=Topics(namespace='x'))
    named = Topics(namespace='x', tf='/tf')
    assert clearance(run, balls, topics=named).times.tolist() == [0.0]


def test_a_robot_of_a_namespace_is_found_where_none_is_elsewhere(tmp_path):
    told = [(0.0, '/x/robot_description', recorder.text(URDF)), *joints('/x/joint_states')]
    run = recorder.record(tmp_path / 'run', told)
    with pytest.raises(RecordingError, match=r'robot_description=/x/robot_description.*space x'):
        clearance(run)
    with pytest.raises(RecordingError, match=r"the base of 'arm' never had a pose.*--world-frame"):
        clearance(run, topics=Topics(namespace='x'))
    root = 'base'
    found = clearance(run, topics=Topics(namespace='x'), world_frame=root)
    assert np.isfinite(found['all'].distance).all()


def test_a_recording_without_a_message_says_so(tmp_path, balls):  # noqa: F811
    silent = [('/joint_states', 'sensor_msgs/msg/JointState')]
    for sqlite in (False, True):
        run = recorder.record(tmp_path / f'run{sqlite}', [], sqlite=sqlite, silent=silent)
        with pytest.raises(RecordingError, match='no message was recorded'):
            clearance(run, balls)


def test_a_report_is_in_a_folder_of_the_name_of_its_run(tmp_path, balls, monkeypatch):  # noqa: F811
    run = recorder.record(tmp_path / 'runs' / 'run', poses([0.0], 'ab', [[HERE, HERE]]))
    monkeypatch.chdir(tmp_path)
    for asked, out in ((run, 'run_report'), (recorder.file_of(run), 'run_report')):
        main(['report', str(asked), '--scene', str(balls), '--pictures', '0'])
        assert (tmp_path / out / 'report.html').is_file()
    monkeypatch.chdir(tmp_path / 'runs')
    for _ in range(2):
        main(['report', '.', '--scene', str(balls), '--pictures', '0'])
    assert (tmp_path / 'runs' / 'runs_report' / 'run' / 'report.html').is_file()
    assert not (tmp_path / 'runs' / 'runs_report' / 'runs_report').exists()
