"""The command of docs/installation.md builds a workspace, and the node starts from it.

The messages take minutes: here they are those that the tests run with, an underlay as any other,
and colcon is told to build what lies above. The whole command is run by whoever changes it.
"""

import os
import re
import shutil
import subprocess

import pytest
from conventions.source_tree import ROOT
from drake_geom_msgs import srv
from ros.harness import environment
from ros.scene_calls import accepted

from drake_geom_ros.common.children import end

PAGE = (ROOT / 'docs/installation.md').read_text()
(BUILD,) = re.findall(r'^    (colcon build --base-paths .*)$', PAGE, re.MULTILINE)
LEFT_OUT = shutil.ignore_patterns('.*', 'build', 'install', 'log', 'out', '__pycache__')

pytestmark = [
    pytest.mark.packaging,
    pytest.mark.topics,
    pytest.mark.skipif(not shutil.which('colcon'), reason='colcon is not installed'),
]


def beside_the_tree():
    """Return the environment of the tests without this source tree on Python's path."""
    variables = environment()
    paths = variables['PYTHONPATH'].split(os.pathsep)
    variables['PYTHONPATH'] = os.pathsep.join(path for path in paths if path != str(ROOT))
    return variables


@pytest.fixture(scope='module')
def workspace(tmp_path_factory):
    """Return a workspace that the command has built."""
    folder = tmp_path_factory.mktemp('workspace')
    shutil.copytree(ROOT, folder / 'src/drake_geom_ros', ignore=LEFT_OUT)
    built = subprocess.run(
        [*BUILD.split(), '--packages-select', 'drake_geom_ros'],
        cwd=folder,
        env=beside_the_tree(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    return folder


def sourced(workspace, command):
    """Return what starts a command in a shell that has sourced the workspace."""
    return ['bash', '-c', f'source install/setup.bash && exec {command}']


def test_the_command_finds_both_packages(workspace):
    command = BUILD.replace('colcon build', 'colcon list --names-only')
    listed = subprocess.run(
        command.split(), cwd=workspace, capture_output=True, text=True, check=True
    ).stdout
    assert {'drake_geom_ros', 'drake_geom_msgs'} <= set(listed.split())


def test_the_node_of_the_workspace_answers(workspace, lone_client):
    found = subprocess.run(
        sourced(workspace, 'python -c "import drake_geom_ros as d; print(d.__file__)"'),
        cwd=workspace,
        env=beside_the_tree(),
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert found.startswith(str(workspace / 'install'))
    # As `ros2 run` finds it, with a scene that lies in the package's share.
    prefix = workspace / 'install/drake_geom_ros'
    scene = prefix / 'share/drake_geom_ros/scenes/minimal.yaml'
    command = f'{prefix}/lib/drake_geom_ros/scene_graph_node --ros-args -p scene_file:={scene}'
    log = workspace / 'node.log'
    lone_client.server = '/workspace/scene_graph'
    with log.open('w') as output:
        node = subprocess.Popen(
            sourced(workspace, f'{command} -r __ns:=/workspace'),
            cwd=workspace,
            env={**beside_the_tree(), 'NUMBA_DISABLE_JIT': '1'},  # it is there for one question
            stdout=output,
            stderr=subprocess.STDOUT,
        )
        try:
            answer = accepted(lone_client.call(srv.HasCollisions, 'has_collisions'))
            assert not answer.has_collisions
        finally:
            code = end(node, 20.0)
    assert 'loaded 1 frame and 3 geometries' in log.read_text()
    assert code == 0, log.read_text()
