"""The cache of compiled code: used again, never stale, and not needed."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import config, types
from numba.core import event

import drake_geom_ros
from drake_geom_ros.geometry._proximity import compiled

ROOT = Path(drake_geom_ros.__file__).parents[1]
SCRIPT = """
import math
from drake_geom_ros.geometry._proximity.compiled import CACHE_FOLDER
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


def test_a_second_process_finds_what_the_first_compiled(tmp_path):
    folder, hits, misses = run(XDG_CACHE_HOME=str(tmp_path))
    assert folder.startswith(str(tmp_path / 'drake_geom_ros'))
    assert (hits, misses) == (0, 1)
    assert run(XDG_CACHE_HOME=str(tmp_path)) == (folder, 1, 0)
    assert run(NUMBA_CACHE_DIR=str(tmp_path / 'mine'))[0].startswith(str(tmp_path / 'mine'))


def test_no_place_for_a_cache_is_no_obstacle(tmp_path):
    blocked = tmp_path / 'a file'
    blocked.write_text('')
    folder = run(XDG_CACHE_HOME=str(blocked), TMPDIR=str(tmp_path))[0]
    assert folder.startswith(str(tmp_path))
    assert run(NUMBA_CACHE_DIR=str(blocked))[:2] == ('', 0)


def test_nobody_else_can_reach_into_the_folder_of_a_cache(tmp_path):
    """Who can write to it can have us run his code."""
    before = os.umask(0)
    try:
        assert compiled._own_folder(tmp_path / 'ours')
    finally:
        os.umask(before)
    assert (tmp_path / 'ours').stat().st_mode & 0o777 == 0o700
    assert compiled._own_folder(tmp_path / 'ours')


def test_another_source_is_another_cache(tmp_path):
    copy = tmp_path / 'package'
    subprocess.run(['cp', '-r', str(ROOT / 'drake_geom_ros'), str(copy)], check=True)
    script = 'import runpy, sys; print(runpy.run_path(sys.argv[1])["_digest"]())'
    path = str(copy / 'geometry/_proximity/compiled.py')

    def digest():
        return subprocess.check_output([sys.executable, '-c', script, path], text=True)

    before = digest()
    assert digest() == before
    source = copy / 'geometry/_proximity/kernels/vectors.py'
    source.write_text(source.read_text() + '\n')
    assert digest() != before


def version(base, k):
    """Make the cache folder of the k-th of some older sources, and return it."""
    folder = base / f'kernels-{k:016x}'
    folder.mkdir(parents=True)
    os.utime(folder, (k, k))
    return folder


@pytest.mark.skipif(config.DISABLE_JIT, reason='nothing is compiled')
def test_old_versions_are_removed_when_something_is_compiled(tmp_path):
    base = tmp_path / 'drake_geom_ros'
    old = [version(base, k) for k in range(8)]
    mine = Path(run(XDG_CACHE_HOME=str(tmp_path))[0])
    assert set(base.iterdir()) == {mine, *old[4:]}
    more = [version(base, k) for k in range(10, 18)]
    assert run(XDG_CACHE_HOME=str(tmp_path))[1:] == (1, 0)
    assert set(base.iterdir()) == {mine, *old[4:], *more}


def test_what_others_keep_in_the_folder_stays(tmp_path):
    theirs = [tmp_path / f'{k:016x}' for k in range(8)]
    theirs += [tmp_path / 'drake_geom_ros' / f'{k:016x}' for k in range(8)]
    for folder in theirs:
        folder.mkdir(parents=True)
    mine = Path(run(NUMBA_CACHE_DIR=str(tmp_path))[0])
    assert mine.parent == tmp_path / 'drake_geom_ros'
    assert all(folder.is_dir() for folder in theirs)


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
    monkeypatch.setattr(compiled, 'intermediate', None)

    @compiled.compiled
    def inner(x, k):
        return x * k

    @compiled.compiled
    def outer(x):
        return inner(x, 2) + inner(x, k=3)

    assert outer(2.0) == 10.0
    assert len(inner.signatures) == 1


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


@compiled.compiled
def total(numbers, factor):
    result = 0.0
    for k in range(numbers.size):
        result += numbers[k]
    return factor * result


def test_an_entry_is_compiled_for_its_kinds_when_it_is_first_called():
    entry = compiled.Entry(total, types.float64[::1], types.int64)
    assert config.DISABLE_JIT or not total.overloads
    for count, factor, expected in ((4, 2, 12.0), (5, 3, 30.0)):
        assert entry.call(np.arange(float(count)), factor) == expected
        assert config.DISABLE_JIT or len(total.overloads) == 1


@compiled.brief
def halved(x):
    return 0.5 * x


def test_what_is_brief_is_compiled_as_all_is():
    assert halved(3.0) == 1.5
    if not config.DISABLE_JIT:
        assert halved.targetoptions == {**total.targetoptions, 'nogil': False}
