"""Without what relies on the inside of one version of Numba, answers are the same."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from conventions.source_tree import ROOT
from numba import config
from oracles.engine_calls import has_overlap, signed_distances
from oracles.worlds import filters_of, random_world

from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.runtime import compiled

# Compiles the kernels of spheres and all that queries need, in the slow way.
pytestmark = [pytest.mark.processes, pytest.mark.everything]

CODE = """
import json
import numba
numba.version_info = numba.version_info._replace(short=(0, 0))  # as if it were another one
from geometry._proximity.runtime.test_pipeline import answers
from drake_geom_ros.geometry._proximity.runtime import compiled
print(json.dumps([compiled.numba_inside is None, *answers()]))
"""


def answers():
    """Return what is answered about some balls, in lists."""
    world = random_world(np.random.default_rng(0), 30, types=(1,), anchored=5)
    engine, filters = Engine(), filters_of(world)
    batch = signed_distances(engine, world, filters, 'exact', 0.5)
    return [batch.ids.tolist(), batch.rows.tolist(), has_overlap(engine, world, filters, 'exact')]


@pytest.mark.skipif(config.DISABLE_JIT, reason='nothing is compiled')
def test_another_numba_gives_the_same_answers(tmp_path):
    """By its public ways alone: references are counted, and ``numba.cfunc`` makes addresses."""
    if compiled.numba_inside is None:
        pytest.skip('this is another Numba')
    done = subprocess.run(
        [sys.executable, '-W', 'ignore', '-c', CODE],
        env={
            **os.environ,
            'PYTHONPATH': f'{ROOT}:{ROOT / "test"}',
            'NUMBA_CACHE_DIR': str(tmp_path),
            'NUMBA_OPT': '0',  # which is compiled in half of the time
        },
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.count('compiled in the slow way by Numba') == 1
    without, *found = json.loads(done.stdout)
    assert without
    ids, rows, overlaps = answers()
    assert found[0] == ids
    np.testing.assert_allclose(found[1], rows, rtol=1e-12, atol=1e-15)
    assert found[2] == overlaps
