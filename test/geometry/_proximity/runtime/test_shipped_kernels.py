"""Kernels for any CPU that the package brings: they answer at once, wherever it is installed."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from numba import config

import drake_geom_ros
from drake_geom_ros.geometry._proximity.runtime import compiled

if config.DISABLE_JIT:
    pytest.skip('nothing is compiled', allow_module_level=True)
if compiled.numba_inside is None:
    pytest.skip('of the pinned version of Numba only', allow_module_level=True)

pytestmark = pytest.mark.processes

PACKAGE = Path(drake_geom_ros.__file__).parent
SCRIPT = """
from drake_geom_ros.geometry._proximity.runtime.compiled import CACHE_FOLDER, kernels_in_words
from drake_geom_ros.geometry._proximity.kernels.vectors import dot
assert dot((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)) == 32.0
print(sum(dot.stats.cache_misses.values()), kernels_in_words(), CACHE_FOLDER, sep='|')
"""
# All kernels of a package of one.
EVERY_KERNEL = """
from drake_geom_ros.geometry._proximity.kernels.vectors import dot
def compile_every_kernel():
    dot((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
"""
THIS_CPU, ANY_CPU = 'for this CPU', 'for any CPU of this type (DRAKE_GEOM_ROS_COMPILE is {})'


@pytest.fixture(scope='module')
def package(tmp_path_factory):
    """Return the folder of a package that brings a kernel, compiled where it was not installed."""
    folder = tmp_path_factory.mktemp('built')
    tree = folder / 'tree/drake_geom_ros'
    shutil.copytree(PACKAGE, tree, ignore=shutil.ignore_patterns('__pycache__', '_kernels'))
    (tree / 'every_kernel.py').write_text(EVERY_KERNEL)
    assert answer(tree, NUMBA_CACHE_DIR=folder / 'cache', NUMBA_CPU_NAME='generic')[0] == 1
    site = tmp_path_factory.mktemp('installed') / 'site'
    shutil.copytree(tree, site / 'drake_geom_ros')
    shutil.copytree(folder / 'cache/drake_geom_ros', site / 'drake_geom_ros/_kernels')
    return site / 'drake_geom_ros'


def answer(package, **variables):
    """Return what a new process compiled, which kernels serve, its cache, and its errors."""
    unset = ('NUMBA_', 'DRAKE_GEOM_ROS_', 'XDG_')
    env = {name: value for name, value in os.environ.items() if not name.startswith(unset)}
    env |= {'PYTHONPATH': str(package.parent), **{k: str(v) for k, v in variables.items()}}
    command = [sys.executable, '-c', SCRIPT]
    done = subprocess.run(command, env=env, cwd='/', capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    misses, words, folder = done.stdout.strip().split('|')
    return int(misses), words, folder, done.stderr


def test_they_answer_in_another_folder_and_nothing_is_compiled(package, tmp_path):
    variables = {'NUMBA_CACHE_DIR': tmp_path, 'DRAKE_GEOM_ROS_COMPILE': 'never'}
    for _ in range(2):
        misses, words, _, errors = answer(package, **variables)
        assert (misses, words, errors) == (0, ANY_CPU.format('never'), '')
    assert list(tmp_path.rglob('*.kernel')) == []


def test_they_answer_where_no_folder_can_be_written(package, tmp_path):
    blocked = tmp_path / 'a file'
    blocked.write_text('')
    misses, words, folder, errors = answer(package, NUMBA_CACHE_DIR=blocked)
    assert (misses, words, folder, errors) == (0, ANY_CPU.format('behind'), '', '')


def test_first_compiles_for_this_cpu_before_it_answers(package, tmp_path):
    variables = {'NUMBA_CACHE_DIR': tmp_path, 'DRAKE_GEOM_ROS_COMPILE': 'first'}
    assert answer(package, **variables)[:2] == (1, THIS_CPU)
    assert answer(package, **variables)[:2] == (0, THIS_CPU)
    del variables['DRAKE_GEOM_ROS_COMPILE']
    assert answer(package, **variables)[:2] == (0, THIS_CPU)


def test_by_default_a_process_compiles_beside_and_the_next_one_uses_it(package, tmp_path):
    misses, words, folder, errors = answer(package, NUMBA_CACHE_DIR=tmp_path)
    assert (misses, words) == (0, ANY_CPU.format('behind'))
    assert errors.count('\n') == 1
    end = time.monotonic() + 200.0
    while not list(Path(folder).glob('compiled-*')):
        assert time.monotonic() < end, (Path(folder) / 'behind.log').read_text()
        time.sleep(0.05)
    assert answer(package, NUMBA_CACHE_DIR=tmp_path)[:2] == (0, THIS_CPU)


def test_kernels_of_other_sources_are_not_used(package, tmp_path):
    changed = tmp_path / 'drake_geom_ros'
    shutil.copytree(package, changed)
    source = changed / 'geometry/_proximity/kernels/vectors.py'
    source.write_text(source.read_text() + '\n')
    misses, words, *_ = answer(changed, NUMBA_CACHE_DIR=tmp_path / 'cache')
    assert (misses, words) == (1, THIS_CPU)


def test_a_broken_kernel_is_compiled_anew(package, tmp_path):
    broken = tmp_path / 'drake_geom_ros'
    shutil.copytree(package, broken)
    (path,) = broken.rglob('*.kernel')
    path.write_bytes(path.read_bytes()[:-1])
    misses, words, *_ = answer(broken, NUMBA_CACHE_DIR=tmp_path / 'cache')
    assert (misses, words) == (1, THIS_CPU)
