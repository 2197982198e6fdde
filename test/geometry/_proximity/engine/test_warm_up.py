"""After a rehearsal nothing but kernels is left to compile."""

import os
import subprocess
import sys

import pytest

from drake_geom_ros.geometry._proximity.engine.warm_up import warm_up

CODE = """
import math
import numpy as np
from numba.core import event
from oracles.engine_calls import candidates, has_overlap, signed_distances
from oracles.worlds import filters_of
from oracles.worlds import random_world, shuffle
from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.pairs.level_costs import seconds_a_pair
from drake_geom_ros.geometry._proximity.engine.warm_up import warm_up

rng = np.random.default_rng(0)
world = random_world(rng, 30, types=(1,), anchored=5)
warm_up()
engine, filters = Engine(), filters_of(world)
engine.prepare(world)
with event.install_recorder('numba:compile') as recorder:
    for _ in range(5):
        for reach in (0.0, math.inf):
            signed_distances(engine, world, filters, 'exact', reach, time_budget=1e-12)
            left = engine.effects.unrefined_pairs
            signed_distances(engine, world, filters, 'exact', reach)
            seconds_a_pair(world, filters, reach, 64, 0)
        has_overlap(engine, world, filters, 'exact')
        candidates(engine, world, filters, 0.1)
        shuffle(rng, world)
print(len(recorder.buffer), left > 0)
"""


@pytest.mark.processes
def test_cycles_compile_nothing_after_it():
    done = subprocess.run(
        [sys.executable, '-c', CODE],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, 'PYTHONPATH': 'test:.'},
    )
    assert done.stdout.strip() == '0 True'


def test_it_goes_through_in_any_process():
    warm_up()
