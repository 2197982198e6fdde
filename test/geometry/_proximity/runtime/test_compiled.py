"""The cache of compiled code: used again, never stale, and not needed."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from geometry._proximity.runtime import compiled_sources
from numba import config
from numba.core import event

import drake_geom_ros
from drake_geom_ros.geometry._contact_surfaces import compiled as contact_surfaces
from drake_geom_ros.geometry._joint_gradients import compiled as joint_gradients
from drake_geom_ros.geometry._proximity.runtime import compiled
from drake_geom_ros.geometry._proximity.runtime.sources import SOURCES, UNCOMPILED
from drake_geom_ros.geometry._rendering import compiled as rendering
from drake_geom_ros.geometry._stops import compiled as stops

pytestmark = pytest.mark.processes

ROOT = Path(drake_geom_ros.__file__).parents[1]
SCRIPT = """
import math
from drake_geom_ros.geometry._proximity.runtime.compiled import CACHE_FOLDER
from drake_geom_ros.geometry._proximity.kernels.vectors import dot
assert dot((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)) == 32.0
stats = dot.stats
print(CACHE_FOLDER, sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""


def run(**environment):
    """Run SCRIPT in a fresh interpreter; return cache folder, hits and misses."""
    env = {k: v for k, v in os.environ.items() if not k.startswith('NUMBA_')}
    env.update(PYTHONPATH=str(ROOT), **environment)
    out = subprocess.run([sys.executable, '-c', SCRIPT], env=env, capture_output=True, text=True)
    assert out.returncode == 0, out.stderr
    *folder, hits, misses = out.stdout.split(' ')
    return ' '.join(folder), int(hits), int(misses)


@pytest.mark.processes
def test_a_second_process_finds_what_the_first_compiled(tmp_path):
    folder, hits, misses = run(XDG_CACHE_HOME=str(tmp_path))
    assert folder.startswith(str(tmp_path / 'drake_geom_ros'))
    assert (hits, misses) == (0, 1)
    assert run(XDG_CACHE_HOME=str(tmp_path)) == (folder, 1, 0)
    assert run(NUMBA_CACHE_DIR=str(tmp_path / 'mine'))[0].startswith(str(tmp_path / 'mine'))


@pytest.mark.processes
def test_no_place_for_a_cache_is_no_obstacle(tmp_path):
    blocked = tmp_path / 'a file'
    blocked.write_text('')
    folder = run(XDG_CACHE_HOME=str(blocked), TMPDIR=str(tmp_path))[0]
    assert folder.startswith(str(tmp_path))
    assert run(NUMBA_CACHE_DIR=str(blocked))[:2] == ('', 0)


def _count_up(array, room):
    for k in range(array.size):
        room[k] = array[k] + 1.0
    return array.size


def test_an_entry_takes_what_it_is_for_and_compiles_nothing_for_others():
    given, own = compiled.given(np.float64, 1), compiled.own(np.float64, 1)
    entry = compiled.Entry(_count_up, given, own)
    some, room = np.arange(6.0), np.zeros(3)
    held = some[::2]
    held.flags.writeable = False
    for _ in range(2):
        room[:] = 0.0
        assert entry.call(held, room) == 3  # of any strides, and only read
        assert room.tolist() == [1.0, 3.0, 5.0]
        for other in (np.zeros((3, 1)), np.zeros((1, 1, 3))):
            with pytest.raises(TypeError):
                entry.call(other, room)
    if not config.DISABLE_JIT:
        assert len(entry.call.signatures) == 1
        for other in (np.zeros(3, dtype=np.float32), [1.0], None):
            with pytest.raises(TypeError):
                entry.call(other, room)


def test_a_journal_lists_what_each_process_compiles(tmp_path):
    journal = tmp_path / 'journal'
    variables = {
        'XDG_CACHE_HOME': str(tmp_path),
        'DRAKE_GEOM_ROS_COMPILE_LOG': str(journal),
    }
    folder = run(**variables)[0]
    run(**variables)  # from the cache
    (row,) = [line.split('\t') for line in journal.read_text().splitlines()]
    assert row[1] == folder
    assert row[2] == 'drake_geom_ros.geometry._proximity.kernels.vectors.dot'
    assert 'float64' in row[3]


READING = """
import numpy as np
from drake_geom_ros.geometry._proximity.runtime.compiled import CACHE_FOLDER
from drake_geom_ros.geometry._proximity.world.pose_rows import read_poses
from drake_geom_ros.geometry._rendering.compiled import ROOM
count = read_poses(np.array([[0, 0, 0, 0, 0, 0, 1.01]]), np.empty((1, 12)))
print(count, CACHE_FOLDER, ROOM.folders.own)
"""


@pytest.fixture
def copied(tmp_path):
    """Return a copy of the package, and what reads a quaternion of length 1.01 in it."""
    package = tmp_path / 'drake_geom_ros'
    shutil.copytree(ROOT / 'drake_geom_ros', package, ignore=shutil.ignore_patterns('__pycache__'))
    env = {**os.environ, 'PYTHONPATH': str(tmp_path), 'NUMBA_CACHE_DIR': str(tmp_path / 'cache')}

    def read():
        told = subprocess.check_output(
            [sys.executable, '-c', READING], env=env, cwd=tmp_path, text=True
        )
        count, folder, images = told.split()
        return int(count), folder, images

    return package, read


@pytest.mark.processes
def test_what_was_compiled_with_another_tolerance_is_not_used(copied):
    """A tolerance outside the folder of the kernels is compiled in like those beside them."""
    package, read = copied
    before = read()
    assert read() == before
    tolerances = package / 'math/tolerances.py'
    text = tolerances.read_text()
    tolerances.write_text(re.sub('QUATERNION_NORM = .*', 'QUATERNION_NORM = 5e-2', text))
    after = read()
    assert (before[0], after[0]) == (0, 1)
    if not config.DISABLE_JIT:
        assert before[1] != after[1]
        assert not after[2].startswith(before[1])


@pytest.mark.processes
@pytest.mark.parametrize('of_images', [False, True])
def test_another_source_is_another_cache(copied, of_images):
    package, read = copied
    before = read()
    room = '_rendering/kernels/windows.py' if of_images else '_proximity/kernels/vectors.py'
    source = package / 'geometry' / room
    source.write_text(source.read_text() + '\n')
    after = read()
    assert before[2] != after[2]
    assert (before[1] == after[1]) is of_images


def test_what_is_not_compiled_leaves_the_cache_as_it_is(copied):
    package, read = copied
    before = read()
    for name in sorted(UNCOMPILED):
        source = package / name.relative_to(ROOT / 'drake_geom_ros')
        source.write_text(source.read_text() + '\n')
    assert read() == before


def test_the_files_that_are_not_compiled_are_those_that_no_compiled_function_uses():
    proximity = ROOT / 'drake_geom_ros/geometry/_proximity'
    runtime = proximity / 'runtime'  # the compiler itself, and its options
    used = compiled_sources.used_by_compiled_code(proximity)
    modules = {path for path in proximity.rglob('*.py') if path.name != '__init__.py'}
    unused = {path for path in modules - used if not path.is_relative_to(runtime)}
    assert sorted(map(str, UNCOMPILED ^ unused)) == []


def test_a_constant_a_record_and_a_function_of_another_file_are_seen_in_compiled_code():
    used = compiled_sources.used_by_compiled_code(ROOT / 'drake_geom_ros/geometry/_proximity')
    relative = {str(path.relative_to(ROOT / 'drake_geom_ros')) for path in used}
    assert relative >= {
        'math/tolerances.py',
        'geometry/_proximity/kernels/vectors.py',
        'geometry/_proximity/kernels/pair_table.py',
        'geometry/_proximity/world/arrays.py',
    }


@pytest.mark.parametrize(
    ('folder', 'sources'),
    [
        ('_proximity', SOURCES),
        ('_rendering', (*SOURCES, *rendering.SOURCES)),
        ('_contact_surfaces', (*SOURCES, *contact_surfaces.SOURCES)),
        ('_joint_gradients', (*SOURCES, *joint_gradients.SOURCES)),
        ('_stops', (*SOURCES, *stops.SOURCES)),
    ],
)
def test_all_that_compiled_code_uses_is_looked_at(folder, sources):
    used = compiled_sources.used_by_compiled_code(ROOT / 'drake_geom_ros/geometry' / folder)
    unseen = [
        str(path.relative_to(ROOT))
        for path in used
        if not any(path.is_relative_to(source) for source in sources)
    ]
    assert unseen == []


@pytest.mark.skipif(config.DISABLE_JIT, reason='nothing is compiled')
def test_a_constant_makes_no_version_of_its_own():
    @compiled.compiled
    def product(x, k):
        return x * k

    @compiled.compiled
    def several(x):
        return product(x, 1) + product(x, k=2) + product(x, len((x, x, x)))

    with event.install_recorder('numba:compile') as recorder:
        assert several(1.0) == 6.0
    ended = [e.data['dispatcher'].py_func for _, e in recorder.buffer if e.is_end]
    assert ended.count(product.py_func) == 1


@pytest.mark.skipif(config.DISABLE_JIT, reason='nothing is compiled')
@pytest.mark.parametrize('decorator', [compiled.compiled, compiled.inlined, compiled.allocating])
def test_what_compiled_code_calls_has_no_version_for_python_until_that_calls_it(decorator):
    @decorator
    def inner(x):
        return x * x

    @compiled.allocating
    def outer(x):
        return inner(x) + inner(x + 1.0)

    assert outer(2.0) == 13.0
    assert inner.signatures == []
    assert inner(3.0) == 9.0
    assert len(inner.signatures) == 1


@pytest.mark.skipif(config.DISABLE_JIT, reason='nothing is compiled')
def test_another_numba_compiles_in_its_own_way(monkeypatch):
    monkeypatch.setattr(compiled, 'numba_inside', None)

    @compiled.compiled
    def inner(x, k):
        return x * k

    @compiled.compiled
    def outer(x):
        return inner(x, 2) + inner(x, k=3)

    assert outer(2.0) == 10.0
    assert inner.signatures  # one for each constant


@pytest.mark.skipif(config.DISABLE_JIT, reason='nothing is compiled')
def test_what_has_to_be_compiled_is_told_once_and_what_is_there_is_not():
    @compiled.compiled
    def double(x):
        return x + x

    @compiled.compiled
    def quadruple(x):
        return double(double(x))

    told = []
    for _ in range(2):
        with compiled.compilation(lambda *what: told.append(what), 'quadruple', 3, 4):
            assert quadruple(1.0) == 4.0
    assert told == [('quadruple', 3, 4)]
    with compiled.compilation(None, 'nobody is told', 1, 1):
        assert quadruple(1) == 4
