"""The launch file: its arguments are the node's parameters; only what is given is passed on."""

import os
import runpy
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
from conventions.source_tree import ROOT
from drake_geom_msgs import srv
from ros.harness import environment
from ros.scene_calls import accepted

from drake_geom_ros.ros.parameters import NodeParameters
from drake_geom_ros.ros.recorder.recorded_topics import topics_of

FILE = ROOT / 'launch/scene_graph.launch.py'
NAMES = {
    'launch': ('LaunchContext', 'LaunchDescription'),
    'launch.actions': ('DeclareLaunchArgument', 'ExecuteProcess', 'LogInfo', 'OpaqueFunction'),
    'launch.substitutions': ('LaunchConfiguration',),
    'launch_ros': (),
    'launch_ros.actions': ('LifecycleNode',),
    'launch_ros.parameter_descriptions': ('ParameterValue',),
}


class Recorded:
    """Stands in for a class of launch: keeps what it was made with."""

    def __init__(self, *values, **named):
        self.values, self.named = values, named


@pytest.fixture
def file(monkeypatch):
    """Return the names of the launch file, run where launch need not be installed."""
    for name, classes in NAMES.items():
        module = ModuleType(name)
        for each in classes:
            setattr(module, each, type(each, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    return SimpleNamespace(**runpy.run_path(str(FILE)))


def declared(file):
    (actions,) = file.generate_launch_description().values
    return {a.values[0]: a.named for a in actions if type(a).__name__ == 'DeclareLaunchArgument'}


def test_every_argument_is_described(file):
    arguments = declared(file)
    assert {'scene_file', 'namespace', 'rate', 'params_file', 'use_sim_time', 'log_level'} <= set(
        arguments
    )
    assert all(argument['description'] for argument in arguments.values())


def test_parameters_are_the_nodes_own(file):
    defaults = {**vars(NodeParameters()), 'use_sim_time': False}
    kinds = {n: file.TEXT_LIST if isinstance(v, tuple) else type(v) for n, v in defaults.items()}
    assert {name: kind for name, (kind, _) in file.PARAMETERS.items()} == kinds


def test_an_argument_that_is_misspelt_is_told_with_the_nearest_name(file):
    given = {name: argument['default_value'] for name, argument in declared(file).items()}
    given |= {'max_distanse': '1', 'robot_of_who_includes_this': 'ur5'}
    told, node = file.start_node(SimpleNamespace(launch_configurations=given))
    assert told.named == {
        'msg': "the launch argument 'max_distanse' does not exist; nearest: 'max_distance'"
    }
    assert node.named['parameters'] == []


def test_what_is_not_given_is_not_passed_on(file):
    given = {name: argument['default_value'] for name, argument in declared(file).items()}
    given |= {'max_distance': '1', 'params_file': 'my.yaml'}
    (node,) = file.start_node(SimpleNamespace(launch_configurations=given))
    settings_file, values = node.named['parameters']
    assert settings_file == 'my.yaml'
    assert list(values) == ['max_distance']
    assert values['max_distance'].named == {'value_type': float}
    (node,) = file.start_node(
        SimpleNamespace(launch_configurations={**given, 'max_distance': '', 'params_file': ''})
    )
    assert node.named['parameters'] == []


def test_a_namespace_may_have_a_tree_of_tf_of_its_own(file):
    given = {name: argument['default_value'] for name, argument in declared(file).items()}
    for own, rules in (('false', []), ('true', file.OWN_TF)):
        context = SimpleNamespace(launch_configurations={**given, 'own_tf': own})
        (node,) = file.start_node(context)
        assert node.named['remappings'] == rules


def test_a_run_is_recorded_with_all_that_a_report_takes(file):
    given = {name: argument['default_value'] for name, argument in declared(file).items()}
    assert len(file.start_node(SimpleNamespace(launch_configurations=given))) == 1
    given |= {'record': 'true', 'namespace': 'cell', 'own_tf': 'true', 'name': 'geometry'}
    recorder, _ = file.start_node(SimpleNamespace(launch_configurations=given))
    command = recorder.named['cmd']
    assert command[:5] == ['ros2', 'bag', 'record', '--storage', 'mcap']
    assert {'/cell/tf', '/cell/tf_static', '/cell/joint_states', '/clock'} <= set(command)
    assert {'/cell/geometry/frame_poses', '/cell/geometry/scene'} <= set(command)
    assert set(topics_of('/cell/geometry')[-6:]) <= set(command)
    assert '/tf' not in command


def installed():
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return any((Path(p) / 'lib/drake_geom_ros/scene_graph_node').exists() for p in prefixes)


@pytest.mark.topics
@pytest.mark.skipif(
    not (shutil.which('ros2') and installed()),
    reason='ros2 launch comes with a ROS distribution, and finds installed packages only',
)
def test_ros2_launch_starts_the_node(lone_client, tmp_path):
    log = (tmp_path / 'log').open('w')
    arguments = ['scene_file:=scenes/minimal.yaml', 'max_distance:=1', 'use_sim_time:=false']
    launch = subprocess.Popen(
        ['ros2', 'launch', str(FILE), *arguments],
        cwd=ROOT,
        env=environment(),
        stdout=log,
        stderr=subprocess.STDOUT,
    )
    try:
        accepted(lone_client.call(srv.HasCollisions, 'has_collisions'))
    finally:
        launch.send_signal(signal.SIGINT)
        launch.wait(30.0)
        log.close()
    assert 'loaded 1 frame and 3 geometries' in (tmp_path / 'log').read_text()


def test_the_node_does_without_shared_memory_unless_told_otherwise(file, monkeypatch):
    context = SimpleNamespace(
        launch_configurations=dict.fromkeys([*file.PARAMETERS, *file.ARGUMENTS], '')
    )
    name = 'FASTDDS_BUILTIN_TRANSPORTS'
    monkeypatch.delenv(name, raising=False)
    assert file.start_node(context)[0].named['additional_env'] == {name: 'UDPv4'}
    monkeypatch.setenv(name, 'LARGE_DATA')
    assert file.start_node(context)[0].named['additional_env'] == {name: 'LARGE_DATA'}
