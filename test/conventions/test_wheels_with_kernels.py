"""`./run wheels`: its wheels hold kernels and messages, and pip makes a node of them."""

import os
import platform
import subprocess
import sys
import zipfile

import pytest
from conventions.source_tree import ROOT
from conventions.test_run import folder, shell
from geometry.scene.test_compilation import CODE

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


@pytest.fixture(scope='session')
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
