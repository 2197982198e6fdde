"""Names that Drake gives to unnamed collision elements, and look-ups by them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.live.conversions.names import NameTable, UnknownNameError
from drake_geom_ros.scene_files import SceneFileError, read_scene, register, save_scene
from drake_geom_ros.scene_files.drake_names import drake_names
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.names import FileNames

SHAPES = {
    'Box': '<box size="1 1 1"/>',
    'Sphere': '<sphere radius="1"/>',
    'Cylinder': '<cylinder radius="1" length="1"/>',
}
INERTIA = (
    '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    '</inertial>'
)


def robot(elements, name='r'):
    """A robot of one link ``a`` with collision elements of these names and kinds."""
    collisions = ''.join(
        f'<collision{f" name={chr(34)}{own}{chr(34)}" if own else ""}>'
        f'<geometry>{SHAPES[kind]}</geometry></collision>'
        for own, kind in elements
    )
    return f'<robot name="{name}"><link name="a">{INERTIA}{collisions}</link></robot>'


def pydrake_names(text):
    parsing = pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    parsing.Parser(plant).AddModelsFromString(text, 'urdf')
    inspector = scene_graph.model_inspector()
    ids = sorted(inspector.GetAllGeometryIds(), key=lambda id: id.get_value())
    return [inspector.GetName(id).rpartition('::')[2] for id in ids]


ELEMENTS = [
    [('', 'Box'), ('', 'Box'), ('', 'Sphere'), ('', 'Box')],
    [('', 'Box'), ('Box', 'Box'), ('', 'Box'), ('Box_1', 'Sphere')],
    [('q', 'Box'), ('q', 'Sphere'), ('q', 'Cylinder'), ('', 'Cylinder')],
    [('collision_1', 'Box'), ('', 'Box'), ('', 'Cylinder')],
]


@pytest.mark.parametrize('elements', ELEMENTS)
def test_names_are_those_of_pydrake(elements):
    own, kinds = zip(*elements, strict=True)
    assert drake_names(own, kinds) == pydrake_names(robot(elements))


@given(
    st.lists(
        st.tuples(st.sampled_from(['', 'Box', 'Box_1', 'q', 'q_1']), st.sampled_from([*SHAPES])),
        max_size=9,
    )
)
def test_names_are_unique_and_begin_with_the_own_name(elements):
    own, kinds = ([pair[k] for pair in elements] for k in range(2))
    names = drake_names(own, kinds)
    assert len(set(names)) == len(names)
    for name, base, kind in zip(names, own, kinds, strict=True):
        assert name.startswith(base or kind)


def tables(text):
    """The look-up of scene files, and that of a node, each by index of the geometry."""
    scene = read_scene(text)
    scene_graph = SceneGraph()
    loaded = register(scene_graph, scene)
    in_file = FileNames(scene.frames, scene.geometries)
    in_node = NameTable(scene_graph.model_inspector())
    index = {geometry.name: k for k, geometry in enumerate(scene.geometries)}

    def find(name):
        return index[in_file.find(name, Location('<test>')).geometry]

    def find_in_node(name):
        return loaded.geometry_ids.index(in_node.geometry(name))

    return find, find_in_node


def test_look_ups_find_both_names():
    for find in tables(robot([('', 'Box'), ('', 'Box'), ('lid', 'Box')])):
        assert [find(f'a/{name}') for name in ('collision_0', 'collision_1', 'lid')] == [0, 1, 2]
        assert [find(f'a/{name}') for name in ('Box', 'Box_1')] == [0, 1]
        assert find('r::a/Box_1') == 1


def test_a_loaded_scene_finds_both_names_and_lists_the_own_one():
    loaded = register(
        SceneGraph(), read_scene(robot([('', 'Box'), ('Box_1', 'Box'), ('', 'Box')]))
    )
    names = ['collision_0', 'Box_1', 'collision_2']
    assert list(loaded.geometries) == [('r', 'a', name) for name in names]
    both = [loaded.geometries['r', 'a', name] for name in ('Box', 'Box_1', 'Box_2')]
    assert both == list(loaded.geometry_ids)
    with pytest.raises(KeyError):
        loaded.geometries['r', 'a', 'Box_3']


def test_an_own_name_counts_before_a_name_of_drake():
    for find in tables(robot([('', 'Box'), ('Box', 'Box')])):
        assert [find('a/collision_0'), find('a/Box')] == [0, 1]


def test_a_name_of_drake_on_two_robots_is_ambiguous():
    scene_graph = SceneGraph()
    scenes = [read_scene(robot([('', 'Box')], name)) for name in 'rs']
    for scene in scenes:
        register(scene_graph, scene)
    table = NameTable(scene_graph.model_inspector())
    with pytest.raises(UnknownNameError, match="2 geometries share the name 'a/Box'"):
        table.geometry('a/Box')
    names = FileNames(
        [f for scene in scenes for f in scene.frames],
        [g for scene in scenes for g in scene.geometries],
    )
    with pytest.raises(SceneFileError, match="'a/Box' matches several"):
        names.find('a/Box', Location('<test>'))
    parts = {'source': 's', 'frame': 'a', 'geometry': 'Box'}
    assert names.find(parts, Location('<test>')).geometry == 'collision_0'


def test_a_saved_scene_has_both_names():
    scene_graph = SceneGraph()
    register(scene_graph, read_scene(robot([('', 'Sphere'), ('', 'Sphere')])))
    for find in tables(save_scene(scene_graph)):
        assert [find('a/collision_1'), find('a/Sphere_1')] == [1, 1]
