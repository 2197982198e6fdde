"""A node with nothing but pip: no clone, no compiler, no CMake, and nothing to source."""

import os
import shutil
import signal
import subprocess
import sys
import zipfile
from email import message_from_bytes

import pytest
from conventions.source_tree import ROOT
from conventions.test_wheel import PINS, run
from conventions.test_wheels_with_kernels import DISTRIBUTION, TAG, dist
from packaging.requirements import Requirement

from drake_geom_ros.common.children import end

__all__ = ['dist']  # the fixture

pytestmark = [pytest.mark.packaging, pytest.mark.processes, pytest.mark.timeout(3000)]
CELL = """
frames:
  - {name: ball, pose: {position: [0.5, 0, 1]}}
geometries:
  - {name: floor, shape: {type: half_space}}
  - {name: ball, frame: ball, shape: {type: sphere, radius: 0.1}}
"""
# The scene is published from the node's being active on, however long that takes.
ASKING = """
from drake_geom_ros.client import SceneGraphClient
with SceneGraphClient(patience=800.0) as client:
    names = sorted(geometry.name for geometry in client.scene().geometries.values())
    print(*names, round(client.signed_distances().closest().distance, 12))
"""


@pytest.fixture(scope='module')
def messages(dist):
    """Return the wheel of messages."""
    (path,) = dist.glob(f'drake_geom_msgs_{DISTRIBUTION}-*.whl')
    return path


def test_messages_need_those_that_they_are_compiled_against(messages):
    with zipfile.ZipFile(messages) as archive:
        (path,) = [name for name in archive.namelist() if name.endswith('/METADATA')]
        metadata = message_from_bytes(archive.read(path))
    needed = {
        each.name: str(each.specifier)
        for each in map(Requirement, metadata.get_all('Requires-Dist'))
    }
    assert needed['ros-geometry-msgs'].startswith('~=')
    assert metadata['Name'] == f'drake-geom-msgs-{DISTRIBUTION}'


def test_messages_name_no_folder_of_this_machine(messages):
    _, _, python, abi, platform = messages.stem.split('-')
    assert (python, abi) == (TAG, TAG)
    assert platform.startswith('manylinux')
    with zipfile.ZipFile(messages) as archive:
        names = archive.namelist()
        texts = [archive.read(name) for name in names if not name.endswith('.so')]
    assert [name for name in names if 'parent_prefix_path' in name] == []
    assert [text for text in texts if str(ROOT).encode() in text] == []


@pytest.fixture(scope='module')
def programs(dist, tmp_path_factory):
    """Return the folder of programs of an environment in which pip installed a node from files."""
    folder = tmp_path_factory.mktemp('installed') / 'venv'
    run(sys.executable, '-m', 'venv', folder, cwd=folder.parent)
    pins = *PINS, '-c', ROOT / f'requirements/{DISTRIBUTION}/lock.txt'
    pip = folder / 'bin/python', '-m', 'pip', 'install', '--find-links', dist, *pins
    run(*pip, f'drake_geom_ros[{DISTRIBUTION}]', cwd=folder.parent, PATH=str(folder / 'bin'))
    return folder / 'bin'


def test_a_node_starts_and_answers(programs, tmp_path):
    (tmp_path / 'my_cell.yaml').write_text(CELL)
    alone = {
        'DRAKE_GEOM_ROS_COMPILE': 'never',
        'HOME': str(tmp_path),
        'PATH': str(programs),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_DOMAIN_ID': os.environ.get('ROS_DOMAIN_ID', '0'),
    }
    assert [shutil.which(name, path=str(programs)) for name in ('cc', 'c++', 'cmake')] == [
        None
    ] * 3
    log = tmp_path / 'log'
    with log.open('w') as output:
        node = subprocess.Popen(
            [programs / 'drake_geom_ros', 'node', 'my_cell.yaml'],
            cwd=tmp_path,
            env=alone,
            stdout=output,
            stderr=subprocess.STDOUT,
        )
    try:
        asked = run(programs / 'python', '-c', ASKING, cwd=tmp_path, **alone)
    finally:
        code = end(node, 60.0, signal.SIGINT)
    assert asked == 'ball floor 0.9\n', log.read_text()
    assert code == 0, log.read_text()


def test_its_definitions_are_found_without_a_source(programs, tmp_path):
    """By the command line too, where a package:// is meant."""
    scene = 'package://drake_geom_ros/scenes/minimal.yaml'
    script = (
        'from pathlib import Path; from drake_geom_ros.scene_files import ResourceResolver\n'
        f'print(ResourceResolver().resolve({scene!r}, Path.cwd()).name)'
    )
    assert run(programs / 'python', '-c', script, cwd=tmp_path) == 'minimal.yaml\n'
