"""`convert FILE.py:FUNCTION`: scenes that programs build with pydrake or MuJoCo."""

from itertools import combinations

import numpy as np
import pytest

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import Role, SceneGraph
from drake_geom_ros.scene_files import load_scene

PYDRAKE = """
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import RevoluteJoint, SpatialInertia, UnitInertia
from pydrake.systems.framework import DiagramBuilder

def build():
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    inertia = SpatialInertia(1.0, [0, 0, 0], UnitInertia(1, 1, 1))
    base, arm, ball = (plant.AddRigidBody(name, inertia) for name in ('base', 'arm', 'ball'))
    plant.WeldFrames(plant.world_frame(), base.body_frame(), RigidTransform([0, 0, 1]))
    plant.AddJoint(RevoluteJoint('j', base.body_frame(), arm.body_frame(), [0, 0, 1]))
    friction = CoulombFriction(0.9, 0.8)
    for body, shape in ((base, Box(1, 1, 1)), (arm, Box(2, 0.1, 0.1)), (ball, Sphere(0.2))):
        plant.RegisterCollisionGeometry(body, RigidTransform(), shape, 'shape', friction)
    plant.Finalize()
    return builder.Build()

def scene_graph():
    return next(s for s in build().GetSystems() if hasattr(s, 'model_inspector'))

def number():
    return 7

def failing():
    return 1 / 0
"""
MUJOCO = """
import mujoco

def build():
    return mujoco.MjModel.from_xml_string(
        '<mujoco model="m"><worldbody><geom type="plane" size="1 1 1"/>'
        '<body name="b" pos="0 0 2"><freejoint/><geom name="ball" size="0.5"/></body>'
        '</worldbody></mujoco>'
    )
"""


def converted(folder, program, function):
    (folder / 'built.py').write_text(program)
    out = folder / 'scene.yaml'
    assert main(['convert', f'{folder}/built.py:{function}', str(out)]) == 0
    scene_graph = SceneGraph()
    return scene_graph, load_scene(out, scene_graph)


def test_a_diagram_comes_along_with_its_filters_and_poses(tmp_path):
    pytest.importorskip('pydrake')
    scene_graph, loaded = converted(tmp_path, PYDRAKE, 'build')
    names = [frame for _, frame in loaded.frames]
    assert names == ['base', 'arm', 'ball']
    manager = scene_graph.collision_filter_manager()
    ids = {frame: id for (_, frame, _), id in loaded.geometries.items()}
    kept = {frozenset(p) for p in combinations(names, 2) if not manager.explain(*map(ids.get, p))}
    assert kept == {frozenset(('base', 'ball')), frozenset(('arm', 'ball'))}
    base = loaded.X_PFs[next(id for (_, name), id in loaded.frames.items() if name == 'base')]
    np.testing.assert_array_equal(base.translation(), [0, 0, 1])


def test_a_scene_graph_alone_has_no_poses(tmp_path):
    pytest.importorskip('pydrake')
    _, loaded = converted(tmp_path, PYDRAKE, 'scene_graph')
    assert loaded.X_PFs == {}
    assert len(loaded.geometries) == 3


def test_a_model_of_mujoco_comes_along(tmp_path):
    pytest.importorskip('mujoco', exc_type=ImportError)
    scene_graph, loaded = converted(tmp_path, MUJOCO, 'build')
    assert scene_graph.model_inspector().NumGeometriesWithRole(Role.kProximity) == 2
    (pose,) = (X for id, X in loaded.X_PFs.items() if id == loaded.frames['m', 'b'])
    np.testing.assert_array_equal(pose.translation(), [0, 0, 2])


@pytest.mark.parametrize(
    ('program', 'function', 'fault'),
    [
        (PYDRAKE.replace('from pydrake', '# from pydrake'), 'number', 'number returned 7; it'),
        (PYDRAKE.replace('from pydrake', '# from pydrake'), 'failing', 'failing failed: Zero'),
        ('x = 1', 'build', "has no function 'build'"),
        ('import nowhere', 'build', 'cannot be run: ModuleNotFoundError'),
        (None, 'build', 'there is no such file'),
    ],
)
def test_what_builds_no_scene_is_refused_in_one_line(tmp_path, capsys, program, function, fault):
    if program is not None:
        (tmp_path / 'built.py').write_text(program)
    out = tmp_path / 'scene.yaml'
    assert main(['convert', f'{tmp_path}/built.py:{function}', str(out)]) == 2
    error = capsys.readouterr().err
    assert fault in error
    assert error.count('\n') == 1
    assert not out.exists()
