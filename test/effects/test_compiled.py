"""What a scene compiles, with an empty cache: all of it for spheres, in a process of its own."""

import json
import os
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT
from numba import config

pytestmark = [pytest.mark.processes, pytest.mark.everything]

CODE = """
import json
from numba.core import event
from drake_geom_ros.geometry import FramePoseVector, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene
with event.install_recorder('numba:compile') as recorder:
    scene = SceneGraph()
    ball = 'shape: {type: sphere, radius: 1}'
    loaded = load_scene('frames: [{name: a}, {name: b}]\\ngeometries:\\n' + '\\n'.join(
        '- {name: g, frame: %s, %s}' % (name, ball) for name in 'ab'), scene)
    context = scene.CreateDefaultContext()
    kernels = context.compile_kernels()
    poses = dict.fromkeys(loaded.frames.values(), RigidTransform())
    context.UpdateFramePoses(FramePoseVector(poses))
    query = scene.get_query_output_port().Eval(context)
    query.ComputeSignedDistancePairwiseClosestPoints()
functions = [e.data['dispatcher'].py_func for _, e in recorder.buffer if e.is_end]
print(json.dumps([kernels, [[f.__module__, f.__name__] for f in functions]]))
"""
KERNELS = 'drake_geom_ros.geometry._proximity.kernels.'


@pytest.fixture(scope='module')
def compiled(tmp_path_factory):
    if config.DISABLE_JIT:
        pytest.skip('nothing is compiled')
    done = subprocess.run(
        [sys.executable, '-c', CODE],
        cwd=ROOT,
        env={**os.environ, 'NUMBA_CACHE_DIR': str(tmp_path_factory.mktemp('cache'))},
        stdout=subprocess.PIPE,
        text=True,
        timeout=800,
        check=True,
    )
    kernels, functions = json.loads(done.stdout)
    return kernels, [tuple(each) for each in functions]


def test_a_scene_of_spheres_compiles_only_kernels_of_spheres(compiled):
    kernels, functions = compiled
    assert kernels == ['closed_forms.spheres.sphere_sphere']
    modules = {m.removeprefix(KERNELS) for m, _ in functions if m.startswith(KERNELS)}
    # Bounds are computed by one function for all shapes, and so are pairs of extreme sizes.
    assert modules == {
        *('addresses', 'vectors', 'calling.extremes', 'calling.pairs'),
        *(f'shapes.{name}' for name in ('bounds', 'hulls', 'maps', 'summit', 'supports')),
        *('closed_forms.points', 'closed_forms.spheres'),
    }
    names = {name for module, name in functions if module == f'{KERNELS}closed_forms.spheres'}
    assert {name for name in names if name.startswith('sphere_')} == {'sphere_sphere'}


def test_no_text_is_compiled(compiled):
    """Numba writes some errors of arrays as text, and to join text is 40 functions."""
    _, functions = compiled
    assert [name for module, name in functions if 'unicode' in module] == []
