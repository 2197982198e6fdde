"""Renderers of a scene graph and of its contexts, by name."""

import os
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT
from geometry.render.scenes import images, query_of

from drake_geom_ros.geometry import (
    MakeRenderEngineExact,
    RenderEngine,
    RenderEngineExactParams,
    RenderLabel,
    Role,
    SceneGraph,
)
from drake_geom_ros.geometry.render import CameraProperties

CAMERA = CameraProperties(4, 3, 0.6, 'a')


def test_renderers_are_added_counted_named_and_removed():
    scene = SceneGraph()
    assert (scene.RendererCount(), scene.HasRenderer('a')) == (0, False)
    scene.AddRenderer('a', MakeRenderEngineExact())
    scene.AddRenderer(name='b', renderer=MakeRenderEngineExact(RenderEngineExactParams()))
    assert (scene.RendererCount(), scene.HasRenderer('a')) == (2, True)
    assert scene.RegisteredRendererNames() == ['a', 'b']
    assert scene.GetRendererTypeName('a') == 'RenderEngineExact'
    assert scene.GetRendererTypeName('c') == ''
    with pytest.raises(RuntimeError, match="'a' is taken"):
        scene.AddRenderer('a', MakeRenderEngineExact())
    with pytest.raises(RuntimeError, match='empty'):
        scene.AddRenderer('', MakeRenderEngineExact())
    with pytest.raises(RuntimeError, match='RenderEngine'):
        scene.AddRenderer('d', None)
    scene.RemoveRenderer('a')
    with pytest.raises(RuntimeError, match=r"no renderer 'a', there are \['b'\]"):
        scene.RemoveRenderer('a')
    assert scene.RegisteredRendererNames() == ['b']


def test_a_context_has_renderers_of_its_own():
    scene = SceneGraph()
    scene.AddRenderer('a', MakeRenderEngineExact())
    context = scene.CreateDefaultContext()
    scene.AddRenderer(context, 'b', MakeRenderEngineExact())
    scene.RemoveRenderer(context, 'a')
    assert scene.RegisteredRendererNames(context) == ['b']
    assert scene.RegisteredRendererNames() == ['a']
    assert scene.Clone().RegisteredRendererNames() == ['a']
    query = scene.get_query_output_port().Eval(context)
    with pytest.raises(RuntimeError, match=r"no renderer 'a', there are \['b'\]"):
        query.render_legend('a')


def test_a_window_and_a_camera_that_is_none_are_refused():
    scene = SceneGraph()
    scene.AddRenderer('a', MakeRenderEngineExact())
    query, W = query_of(scene), scene.world_frame_id()
    pose = query.X_WF(W)
    for render in (query.RenderColorImage, query.RenderLabelImage):
        with pytest.raises(RuntimeError, match='show_window'):
            render(CAMERA, W, pose, show_window=True)
        with pytest.raises(RuntimeError, match='is no camera'):
            render(None, W, pose)
    with pytest.raises(RuntimeError, match='want'):
        images(scene, CAMERA, want=('colour',))
    with pytest.raises(RuntimeError, match='fov_y = 4'):
        images(scene, CameraProperties(4, 3, 4.0, 'a'))
    with pytest.raises(RuntimeError, match='width = 0'):
        images(scene, CameraProperties(0, 3, 1.0, 'a'))


def test_an_engine_is_made_and_shared():
    engine = MakeRenderEngineExact()
    assert isinstance(engine, RenderEngine)
    assert engine.Clone() is engine
    assert engine.default_render_label() == RenderLabel.kDontCare
    assert engine.parameters() == RenderEngineExactParams()
    with pytest.raises(TypeError):
        RenderEngine()


@pytest.mark.parametrize(
    'wrong',
    [
        {'default_label': RenderLabel.kEmpty},
        {'color_samples': 0},
        {'color_samples': 9},
        {'role': Role.kUnassigned},
    ],
)
def test_parameters_that_are_none_are_refused(wrong):
    with pytest.raises(RuntimeError, match=next(iter(wrong))):
        RenderEngineExactParams(**wrong)


@pytest.mark.processes
def test_a_program_without_images_imports_none_of_the_renderer():
    code = (
        'import sys\n'
        'from drake_geom_ros.geometry import *\n'
        'scene = SceneGraph()\n'
        "scene.AddRenderer('a', MakeRenderEngineExact())\n"
        'query = scene.get_query_output_port().Eval(scene.CreateDefaultContext())\n'
        'query.ComputePointPairPenetration()\n'
        "parts = '_rendering', 'render._packing', 'vtk.stage', 'vtk.looks', 'vtkmodules'\n"
        'print([name for name in sys.modules if any(part in name for part in parts)])\n'
    )
    done = subprocess.run(
        [sys.executable, '-c', code],
        cwd=ROOT,
        env={**os.environ, 'NUMBA_DISABLE_JIT': '1'},
        capture_output=True,
        text=True,
        timeout=800,
        check=False,
    )
    assert done.stdout.strip() == '[]', done.stderr
