"""The launch file of examples/ur5_cell: what it starts, with and without a distribution."""

import os
import runpy
import shutil
import signal
import subprocess
import sys
from types import ModuleType, SimpleNamespace

import pytest
import yaml
from conventions.source_tree import ROOT
from ros.harness import LATCHED, environment
from std_msgs.msg import Bool

CELL = ROOT / 'examples/ur5_cell'
FILE = CELL / 'cell.launch.py'
NAMES = {
    'ament_index_python': (),
    'ament_index_python.packages': ('PackageNotFoundError', 'get_package_prefix'),
    'launch': ('LaunchContext', 'LaunchDescription'),
    'launch.actions': ('DeclareLaunchArgument', 'ExecuteProcess', 'OpaqueFunction'),
    'launch.substitutions': ('LaunchConfiguration',),
    'launch_ros': (),
    'launch_ros.actions': ('Node',),
}


class Recorded:
    """Stands in for a class of launch: keeps what it was made with."""

    def __init__(self, *values, **named):
        self.values, self.named = values, named


class NotFoundError(Exception):
    pass


@pytest.fixture
def start(monkeypatch):
    """Return a function that starts the cell where some packages are installed."""

    def start(installed=(), **given):
        for name, classes in NAMES.items():
            module = ModuleType(name)
            for each in classes:
                setattr(module, each, type(each, (Recorded,), {}))
            monkeypatch.setitem(sys.modules, name, module)

        def prefix(package):
            if package not in installed:
                raise NotFoundError(package)

        packages = sys.modules['ament_index_python.packages']
        packages.PackageNotFoundError, packages.get_package_prefix = NotFoundError, prefix
        file = SimpleNamespace(**runpy.run_path(str(FILE)))
        (actions,) = file.generate_launch_description().values
        arguments = {
            a.values[0]: a.named['default_value']
            for a in actions
            if type(a).__name__ == 'DeclareLaunchArgument'
        }
        return file.start(SimpleNamespace(launch_configurations={**arguments, **given}))

    return start


def executables(processes):
    return [p.named.get('executable', 'python') for p in processes]


def test_the_player_moves_the_cell_unless_joints_come_from_elsewhere(start):
    ours = ['scene_graph_node', 'python', 'pose_player']
    assert executables(start()) == ours
    assert executables(start(['joint_state_publisher'])) == ours
    assert executables(start(player='false')) == ours
    described = start(['joint_state_publisher'], player='false')
    assert executables(described) == [*ours[:2], 'joint_state_publisher']
    assert '<robot name="ur5"' in described[-1].named['parameters'][0]['robot_description']


def test_each_cell_has_its_own_topics_and_its_own_rviz(start):
    node, monitor, player, rviz = start(namespace='left', rviz='true')
    for process in (node, player, rviz):
        assert 'namespace' in process.named
    assert '__ns:=/left' in monitor.named['cmd']
    config = yaml.safe_load((CELL / 'cell.rviz').read_text())
    topics = [
        d['Topic']['Value'] for d in config['Visualization Manager']['Displays'] if 'Topic' in d
    ]
    assert topics == ['scene_graph/markers']


def installed():
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return any(os.path.exists(f'{p}/lib/drake_geom_ros/scene_graph_node') for p in prefixes)


@pytest.mark.topics
@pytest.mark.skipif(
    not (shutil.which('ros2') and installed()),
    reason='ros2 launch comes with a ROS distribution, and finds installed packages only',
)
def test_ros2_launch_starts_the_cell(lone_client, tmp_path):
    with (tmp_path / 'log').open('w') as log:
        launch = subprocess.Popen(
            ['ros2', 'launch', str(FILE), 'namespace:=left'],
            env=environment(),
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        try:
            lone_client.server = '/left/stop_monitor'
            stops = lone_client.listen(Bool, 'stop', LATCHED)
            lone_client.wait_for(lambda: any(not stop.data for stop in stops), 'go', 120.0)
        finally:
            launch.send_signal(signal.SIGINT)
            launch.wait(30.0)
