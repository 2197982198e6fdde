"""Scenes that a program has built with pydrake or MuJoCo: the same names, poses and pairs here."""

import numpy as np
import pytest
import trimesh

from drake_geom_ros.geometry import HydroelasticType, Role, SceneGraph
from drake_geom_ros.scene_files import from_mujoco, from_pydrake, read_scene
from drake_geom_ros.scene_files.errors import SceneFileError


def plant_of(geometry=None):
    """Return a plant of pydrake with two links, and its scene graph and diagram."""
    parsing = pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    shapes = (
        '<sphere><radius>0.1</radius></sphere>',
        '<box><size>1 2 3</size></box>',
        '<capsule><radius>0.1</radius><length>1</length></capsule>',
        '<cylinder><radius>0.1</radius><length>1</length></cylinder>',
        '<ellipsoid><radii>1 2 3</radii></ellipsoid>',
        '<plane><normal>0 0 1</normal><size>1 1</size></plane>',
    )
    links = ''.join(
        f'<link name="l{k}"><pose>{k} 0 0 0 0.3 0</pose><collision name="c"><pose>0 0.1 0 0 0 0'
        f'</pose><geometry>{shape}</geometry><drake:proximity_properties>'
        f'<drake:{"rigid" if "plane" in shape else "compliant"}_hydroelastic/>'
        '<drake:hydroelastic_modulus>1e6'
        '</drake:hydroelastic_modulus><drake:mesh_resolution_hint>0.1'
        '</drake:mesh_resolution_hint></drake:proximity_properties></collision>'
        f'<visual name="v"><geometry>{shape}</geometry></visual></link>'
        for k, shape in enumerate(shapes)
    )
    joint = '<joint name="j" type="revolute"><parent>l0</parent><child>l1</child><axis/></joint>'
    parsing.Parser(plant).AddModelsFromString(
        '<sdf version="1.9" xmlns:drake="http://drake.mit.edu"><model name="m">'
        f'{links}{joint}</model></sdf>',
        'sdf',
    )
    if geometry is not None:
        from pydrake.math import RigidTransform
        from pydrake.multibody.plant import CoulombFriction

        plant.RegisterCollisionGeometry(
            plant.GetBodyByName('l0'), RigidTransform(), geometry, 'more', CoulombFriction()
        )
    plant.Finalize()
    return plant, scene_graph, builder.Build()


def pairs_of(inspector):
    return {
        frozenset((inspector.GetName(inspector.GetFrameId(g)), inspector.GetName(g)) for g in pair)
        for pair in inspector.GetCollisionCandidates()
    }


def test_a_plant_of_pydrake_comes_with_names_poses_properties_and_filters():
    _, theirs, diagram = plant_of()
    context = diagram.CreateDefaultContext()
    query = theirs.get_query_output_port().Eval(theirs.GetMyContextFromRoot(context))
    ours = SceneGraph()
    loaded = from_pydrake(theirs, ours, query)
    inspector, of_drake = ours.model_inspector(), theirs.model_inspector()
    assert pairs_of(inspector) == pairs_of(of_drake)
    assert inspector.NumGeometriesWithRole(Role.kIllustration) == 6
    here = ours.get_query_output_port().Eval(ours.CreateDefaultContext())
    drakes = sorted(of_drake.GetAllGeometryIds(), key=lambda g: g.get_value())
    assert len(loaded.geometry_ids) == len(drakes) == of_drake.num_geometries()
    for id, drake in zip(loaded.geometry_ids, drakes, strict=True):
        assert inspector.GetName(id) == of_drake.GetName(drake)
        X_WG = query.GetPoseInWorld(drake).GetAsMatrix4()
        np.testing.assert_allclose(
            here.GetPoseInWorld(id).GetAsMatrix4(), X_WG, rtol=0.0, atol=1e-15
        )
    geometry = loaded.geometries['plant', 'm::l0', 'm::c']
    properties = inspector.GetProximityProperties(geometry)
    assert properties.GetProperty('hydroelastic', 'compliance_type') is HydroelasticType.kCompliant
    assert properties.GetProperty('hydroelastic', 'hydroelastic_modulus') == 1e6


def test_frames_of_pydrake_wait_without_a_query_object():
    _, theirs, _ = plant_of()
    loaded = from_pydrake(theirs, SceneGraph())
    assert not loaded.X_PFs
    assert ('plant', 'm::l0') in loaded.frames


def test_meshes_of_pydrake_are_read_by_their_files(tmp_path):
    pydrake = pytest.importorskip('pydrake.geometry', exc_type=ImportError)
    path = tmp_path / 'block.obj'
    trimesh.creation.box((0.2, 0.3, 0.4)).export(path)
    _, theirs, _ = plant_of(pydrake.Mesh(str(path), [1.0, 2.0, 3.0]))
    ours = SceneGraph()
    loaded = from_pydrake(theirs, ours)
    shape = ours.model_inspector().GetShape(loaded.geometries['plant', 'm::l0', 'm::more'])
    assert shape.source().path() == path
    assert shape.scale3().tolist() == [1.0, 2.0, 3.0]


def test_a_shape_of_pydrake_that_is_not_here_is_refused_by_its_name():
    pydrake = pytest.importorskip('pydrake.geometry', exc_type=ImportError)
    from pydrake.math import RigidTransform

    theirs, ours = pydrake.SceneGraph(), SceneGraph()
    cone = pydrake.GeometryInstance(RigidTransform(), pydrake.MeshcatCone(1.0, 1.0, 1.0), 'cone')
    theirs.RegisterAnchoredGeometry(theirs.RegisterSource('s'), cone)
    with pytest.raises(SceneFileError, match=r's::world/cone: the shape MeshcatCone is not here'):
        from_pydrake(theirs, ours)
    assert ours.model_inspector().num_sources() == SceneGraph().model_inspector().num_sources()


def test_a_compiled_model_of_mujoco_is_the_same_as_its_file():
    mujoco = pytest.importorskip('mujoco', exc_type=ImportError)
    text = (
        '<mujoco model="arm"><worldbody><geom type="plane" size="1 1 1"/><body name="a"><joint '
        'name="j"/><geom size="0.1"/></body></worldbody></mujoco>'
    )
    ours = SceneGraph()
    loaded = from_mujoco(mujoco.MjModel.from_xml_string(text), ours)
    read = read_scene(text + '\n')
    assert loaded.robots['arm'].tree == read.robots[0].tree
    assert [*loaded.geometries] == [('arm', 'world', 'collision_0'), ('arm', 'a', 'collision_0')]
    assert len(ours.model_inspector().GetCollisionCandidates()) == 1
