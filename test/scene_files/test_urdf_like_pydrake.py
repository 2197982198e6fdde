"""Which pairs of a URDF are reported: those of MultibodyPlant, where pydrake is there."""

from itertools import combinations

import pytest

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import read_scene, register

parsing = pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)

GROUP = '<drake:collision_filter_group name="{}" {}>{}</drake:collision_filter_group>'
A, B = '<drake:member link="a"/>', '<drake:member link="b"/>'
ITSELF = '<drake:ignored_collision_filter_group name="g"/>'
OF_H = '<drake:member_group name="h"/>'
CASES = {
    'nothing': '',
    'a group that ignores itself': GROUP.format('g', '', A + B + ITSELF),
    'an ignored group': GROUP.format('g', 'ignore="true"', A + B + ITSELF),
    'one that is not': GROUP.format('g', 'ignore="false"', A + B + ITSELF),
    'true in capitals': GROUP.format('g', 'ignore="TRUE"', A + B + ITSELF),
    'a group in a group': GROUP.format('h', '', A + B) + GROUP.format('g', '', OF_H + ITSELF),
    'one that comes later': GROUP.format('g', '', OF_H + ITSELF) + GROUP.format('h', '', A + B),
    'a ring': GROUP.format('g', '', OF_H + ITSELF)
    + GROUP.format('h', '', '<drake:member_group name="g"/>' + A + B),
    **{
        f'<drake:joint> {kind}': f'<drake:joint name="j" type="{kind}"><parent link="a"/>'
        '<child link="b"/></drake:joint>'
        for kind in ('ball', 'planar', 'universal')
    },
    **{
        f'<joint> {kind}': f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/></joint>'
        for kind in ('fixed', 'continuous', 'floating')
    },
}


def robot(body):
    links = ''.join(
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
        'ixz="0" iyz="0"/></inertial><collision><geometry><sphere radius="1"/></geometry>'
        '</collision></link>'
        for name in 'abc'
    )
    return f'<robot name="r" xmlns:drake="http://drake.mit.edu">{links}{body}</robot>'


def of_pydrake(urdf):
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    parsing.Parser(plant).AddModelsFromString(urdf, 'urdf')
    plant.Finalize()
    inspector = scene_graph.model_inspector()

    def name(geometry):
        return plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).name()

    return {''.join(sorted(map(name, pair))) for pair in inspector.GetCollisionCandidates()}


def of_ours(urdf):
    scene_graph = SceneGraph()
    register(scene_graph, read_scene(urdf))
    inspector, manager = scene_graph.model_inspector(), scene_graph.collision_filter_manager()
    names = {g: inspector.GetName(inspector.GetFrameId(g)) for g in inspector.GetAllGeometryIds()}
    pairs = (pair for pair in combinations(names, 2) if not manager.explain(*pair))
    return {''.join(sorted(map(names.get, pair))) for pair in pairs}


@pytest.mark.parametrize('body', CASES.values(), ids=CASES.keys())
def test_pairs_are_those_of_pydrake(body):
    assert of_ours(robot(body)) == of_pydrake(robot(body))
