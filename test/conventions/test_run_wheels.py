"""`./run wheels`: its wheels hold kernels and messages, and pip makes a node of them."""

import os
import platform
import shutil
import signal
import subprocess
import sys
import zipfile
from email import message_from_bytes

import pytest
from conventions.run_shell import folder, shell
from conventions.source_tree import ROOT
from conventions.test_wheel import PINS, run
from geometry.scene.test_compilation import CODE
from packaging.requirements import Requirement

from drake_geom_ros.common.children import end

__all__ = ['folder']  # the fixture

# The wheel takes minutes: all kernels are compiled for it.
pytestmark = [pytest.mark.packaging, pytest.mark.processes, pytest.mark.timeout(3000)]
TAG = f'cp{sys.version_info.major}{sys.version_info.minor}'
DISTRIBUTION = os.environ.get('ROS_DISTRO', 'kilted')
VERSION = f'{sys.version_info.major}.{sys.version_info.minor}'
# Of the installed package, not of the folder in which it runs.
INSTALLED = f"""
import sys
sys.path.pop(0)
{CODE}
print(g.kernel_state())
print(told)
"""


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
def dist(tmp_path_factory):
    """Return the folder that the command fills, for one Python and one distribution of ROS."""
    out = tmp_path_factory.mktemp('wheels')
    script = f'source ./run; dist={out}; wheels_command {VERSION}'
    done = subprocess.run(
        ['bash', '-c', script],
        cwd=ROOT,
        env={**os.environ, 'ROS_DISTRO': DISTRIBUTION},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope='module')
def wheel(dist):
    """Return the wheel with kernels."""
    (path,) = dist.glob('drake_geom_ros-*.whl')
    return path


def test_its_name_says_for_which_python_and_platform_it_is(wheel):
    name, _, python, abi, system = wheel.stem.split('-')
    assert (name, python, abi) == ('drake_geom_ros', TAG, 'none')
    assert system.startswith('manylinux')
    assert system.endswith(platform.machine())


def test_it_holds_kernels_and_no_locks(wheel):
    with zipfile.ZipFile(wheel) as archive:
        inside = [name for name in archive.namelist() if '/_kernels/' in name]
        size = sum(archive.getinfo(name).compress_size for name in inside)
    assert len(inside) > 50
    assert all(name.endswith('.kernel') for name in inside)
    assert size < 6e6


def files_in(wheel):
    """Return the files of a wheel but its kernels."""
    with zipfile.ZipFile(wheel) as archive:
        return {name for name in archive.namelist() if '/_kernels/' not in name}


def test_the_source_distribution_makes_the_same_package_without_kernels(dist, wheel, tmp_path):
    (source,) = dist.glob('*.tar.gz')
    pip = [sys.executable, '-m', 'pip', 'wheel', '--no-deps', '--no-build-isolation', '-w']
    subprocess.run([*pip, tmp_path, '--no-cache-dir', source], check=True, capture_output=True)
    (made,) = tmp_path.glob('*.whl')
    assert files_in(made) == files_in(wheel)
    assert made.stem.endswith('-py3-none-any')


def test_installed_elsewhere_it_compiles_nothing(wheel, tmp_path):
    """Nor where no folder can be written."""
    site, blocked = tmp_path / 'site', tmp_path / 'a file'
    blocked.write_text('')
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    unset = ('NUMBA_', 'DRAKE_GEOM_ROS_', 'PYTHON')
    env = {name: value for name, value in os.environ.items() if not name.startswith(unset)}
    env |= {'PYTHONPATH': str(site), 'NUMBA_CACHE_DIR': str(blocked)}
    command = [sys.executable, '-c', INSTALLED]
    done = subprocess.run(command, env=env, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    counts, state, told = done.stdout.splitlines()
    assert counts.startswith('0 ')
    assert told == '[]'
    assert state.startswith('for any CPU')
    assert done.stderr == ''


def test_a_set_up_takes_kernels_from_a_wheel(folder, tmp_path):
    """Only from those for its Python and machine."""
    wheels, cache = tmp_path / 'wheels', tmp_path / 'cache'
    wheels.mkdir()
    for tag, kernel in ((TAG, 'right'), ('cp39', 'wrong')):
        name = f'drake_geom_ros-0.1.0-{tag}-none-manylinux_2_28_{platform.machine()}.whl'
        with zipfile.ZipFile(wheels / name, 'w') as archive:
            archive.writestr(f'drake_geom_ros/_kernels/kernels-1/{kernel}.kernel', 'code')
            archive.writestr('drake_geom_ros/__init__.py', '')
    script = f'venv={sys.prefix}; NUMBA_CACHE_DIR={cache} unpack_kernels'
    code, said, errors = shell(folder, script, DRAKE_GEOM_ROS_WHEELS=str(wheels))
    assert code == 0, errors
    assert said.startswith('1 kernels from ')
    files = [path for path in cache.rglob('*') if path.is_file()]
    assert files == [cache / 'drake_geom_ros/kernels-1/right.kernel']
    assert shell(folder, script)[:2] == (0, '')  # where dist/ has none


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
    _, _, python, abi, system = messages.stem.split('-')
    assert (python, abi) == (TAG, TAG)
    assert system.startswith('manylinux')
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
    assert not any(shutil.which(name, path=alone['PATH']) for name in ('cc', 'c++', 'cmake'))
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
