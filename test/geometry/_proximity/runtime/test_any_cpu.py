"""An answer never depends on which kernels serve: those for any CPU, or those for this one."""

import json
import os
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT
from every import report
from numba import config
from oracles import every_answer

from drake_geom_ros.geometry._proximity.runtime import compiled

if config.DISABLE_JIT:
    pytest.skip('nothing is compiled', allow_module_level=True)
if compiled.numba_inside is None:
    pytest.skip('of the pinned version of Numba only', allow_module_level=True)

pytestmark = pytest.mark.processes


def asked(*kinds, **variables):
    """Return all answers of a new process about these kinds of shapes."""
    done = subprocess.run(
        [sys.executable, '-m', 'oracles.every_answer', *kinds],
        env={**os.environ, 'PYTHONPATH': f'{ROOT}:{ROOT / "test"}', **variables},
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def compare(*kinds):
    this_cpu = asked(*kinds, DRAKE_GEOM_ROS_COMPILE='first')
    any_cpu = asked(*kinds, NUMBA_CPU_NAME='generic')
    assert len(this_cpu) > 20
    assert this_cpu.keys() == any_cpu.keys()
    report(
        f'{name}: {a} and {any_cpu[name]}' for name, a in this_cpu.items() if a != any_cpu[name]
    )


def test_answers_about_a_kind_of_shape_are_the_same_to_the_bit():
    compare('Sphere')


@pytest.mark.everything  # compiles all kernels twice: four minutes of a processor
@pytest.mark.timeout(3000)
def test_all_answers_are_the_same_to_the_bit():
    """Every hard case, and so every certificate; random pairs, motions, surfaces and images."""
    compare(*every_answer.ALL_KINDS)


def test_another_answer_is_seen():
    first, second = (
        {'pair': every_answer.digest_of(complex(*numbers))} for numbers in ((1, 0.0), (1, -0.0))
    )
    assert first != second
