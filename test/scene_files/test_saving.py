"""The law of saving: a scene that was saved and loaded is the same scene."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    CollisionFilterDeclaration,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    IllustrationProperties,
    Mesh,
    MeshData,
    ProximityProperties,
    Rgba,
    Role,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import yaml_text, yaml_writer
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.saving import describe
from drake_geom_ros.scene_files.scene_file import load_scene, read_scene, save_scene
from drake_geom_ros.scene_files.yaml_writer import to_yaml

ROLES = (Role.kProximity, Role.kIllustration, Role.kPerception)
NAMES = st.sampled_from(
    [
        'a',
        'b',
        'a::b',
        'a/b',
        'b::a/b',
        '1e-3',
        'null',
        'x y',
        'ä',
        '\n',
        '"',
        '{',
        'world/a',
        '::',
    ]
)
NUMBERS = st.floats(-10, 10)
LENGTHS = st.floats(0.01, 10)
SHAPES = st.one_of(
    st.builds(Sphere, LENGTHS),
    st.builds(Box, LENGTHS, LENGTHS, LENGTHS),
    st.builds(Capsule, LENGTHS, LENGTHS),
)
POSES = st.builds(
    lambda rpy, p: RigidTransform(RollPitchYaw(rpy), p),
    st.tuples(NUMBERS, NUMBERS, NUMBERS),
    st.tuples(NUMBERS, NUMBERS, NUMBERS),
)
VALUES = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(),
    st.lists(NUMBERS, max_size=3),
    st.sets(st.text(), max_size=3),
    st.builds(np.array, st.lists(NUMBERS, max_size=3)).map(np.atleast_1d),
    st.builds(Rgba, *[st.floats(0, 1)] * 4),
)


@st.composite
def properties(draw, kind):
    made = kind()
    for group, name, value in draw(
        st.lists(st.tuples(st.text(), st.text(), VALUES), max_size=2, unique_by=lambda p: p[:2])
    ):
        made.AddProperty(group, name, value)
    return made


@st.composite
def scene_graphs(draw):
    """A scene of up to 3 sources, 6 frames, 10 geometries and 6 words about pairs."""
    scene_graph = SceneGraph()
    frames = []
    geometries = []
    for source_name in draw(st.lists(NAMES, max_size=3, unique=True).map(trimmed)):
        source_id = scene_graph.RegisterSource(source_name)
        parents = [scene_graph.world_frame_id()]
        for name in draw(st.lists(NAMES, max_size=2, unique=True).map(trimmed)):
            parent = draw(st.sampled_from(parents))
            frame = GeometryFrame(name, draw(st.integers(0, 2)))
            parents.append(scene_graph.RegisterFrame(source_id, parent, frame))
        frames += parents[1:]
        for name in draw(st.lists(NAMES, max_size=4, unique=True).map(trimmed)):
            # Anchored geometries of all sources share one frame, and names are unique on it.
            instance = GeometryInstance(draw(POSES), draw(SHAPES), f'{name} of {source_name}')
            if draw(st.booleans()):
                instance.set_proximity_properties(draw(properties(ProximityProperties)))
            if draw(st.booleans()):
                instance.set_illustration_properties(draw(properties(IllustrationProperties)))
            frame_id = draw(st.sampled_from(parents))
            geometries.append(scene_graph.RegisterGeometry(source_id, frame_id, instance))
    draw_filters(draw, scene_graph.collision_filter_manager(), frames, geometries)
    return scene_graph


def shown(value):
    """Return the type and the text of a property, which for a set has no order of its own."""
    return type(value), str(sorted(value) if isinstance(value, set) else value)


def trimmed(names):
    return list(dict.fromkeys(name for name in names if name.strip(' \t')))


def draw_filters(draw, manager, frames, geometries):
    ids = [*frames, *geometries]
    sets = st.lists(st.sampled_from(ids), max_size=4).map(GeometrySet) if ids else st.nothing()
    for _ in range(draw(st.integers(0, 6)) if ids else 0):
        word = draw(st.sampled_from(['group', 'clique', 'declare', 'deactivate']))
        if word == 'group':
            ignored = draw(st.lists(st.sampled_from(['a', 'b', 'universal']), max_size=2))
            manager.AddGroup(draw(st.sampled_from(['a', 'b'])), draw(sets), ignored)
        elif word == 'clique':
            manager.AddClique(draw(NAMES.filter(str.strip)), draw(sets))
        elif word == 'deactivate':
            manager.Deactivate(draw(sets))
        else:
            declaration = CollisionFilterDeclaration()
            for _ in range(draw(st.integers(1, 2))):
                say = draw(st.sampled_from(['Exclude', 'Allow']))
                if draw(st.booleans()):
                    getattr(declaration, f'{say}Within')(draw(sets))
                else:
                    getattr(declaration, f'{say}Between')(draw(sets), draw(sets))
            manager.Apply(declaration)


def snapshot(scene_graph):
    """Everything that can be asked about a scene, with positions in place of ids."""
    inspector = scene_graph.model_inspector()
    manager = scene_graph.collision_filter_manager()
    frame_ids = inspector.GetAllFrameIds()
    geometry_ids = inspector.GetAllGeometryIds()
    sources = inspector.GetAllSourceIds()
    place = {id: k for ids in (sources, frame_ids, geometry_ids) for k, id in enumerate(ids)}

    def properties_of(geometry_id, role):
        found = inspector.GetProperties(geometry_id, role)
        return found and {
            (group, name): shown(value.get_value())
            for group in found.GetGroupNames()
            for name, value in found.GetPropertiesInGroup(group).items()
        }

    return {
        'sources': [inspector.GetName(id) for id in sources],
        'frames': [
            (
                inspector.GetName(id),
                place[inspector.GetOwningSourceId(id)],
                place[inspector.GetParentFrame(id)],
                inspector.GetFrameGroup(id),
            )
            for id in frame_ids
        ],
        'geometries': [
            (
                inspector.GetName(id),
                place[inspector.GetOwningSourceId(id)],
                place[inspector.GetFrameId(id)],
                inspector.GetShape(id),
                inspector.GetPoseInFrame(id).GetAsMatrix34().tolist(),
                [properties_of(id, role) for role in ROLES],
            )
            for id in geometry_ids
        ],
        'candidates': [
            (place[a], place[b]) for a, b in sorted(inspector.GetCollisionCandidates())
        ],
        'groups': {
            name: ([place[id] for id in group.members], set(group.ignored))
            for name, group in manager.filter_groups().items()
        },
        'cliques': {
            name: [place[id] for id in members] for name, members in manager.cliques().items()
        },
        'deactivated': [place[id] for id in manager.deactivated_geometries()],
    }


@settings(max_examples=150)
@given(scene_graphs())
def test_a_scene_that_was_saved_and_loaded_is_the_same(scene_graph):
    text = save_scene(scene_graph)
    loaded = SceneGraph()
    load_scene(text, loaded)
    assert snapshot(loaded) == snapshot(scene_graph)
    # What was said twice about a pair may be said once in the second text.
    assert save_scene(loaded).partition('filters:')[0] == text.partition('filters:')[0]


def scene_with_two_balls():
    scene_graph = SceneGraph()
    source_id = scene_graph.RegisterSource('s')
    ids = []
    for name in 'ab':
        frame_id = scene_graph.RegisterFrame(source_id, GeometryFrame(name))
        for k in range(2):
            ball = GeometryInstance(RigidTransform(), Sphere(1.0), f'{name}{k}')
            ball.set_proximity_properties(ProximityProperties())
            ids.append(scene_graph.RegisterGeometry(source_id, frame_id, ball))
    return scene_graph, ids


def test_a_whole_frame_is_saved_by_its_name():
    scene_graph, (a0, a1, b0, _) = scene_with_two_balls()
    manager = scene_graph.collision_filter_manager()
    manager.AddClique('c', GeometrySet([a0, a1, b0]))
    assert "clique: {name: c, members: ['s::a', 's::b/b0']}" in save_scene(scene_graph)


def test_transient_declarations_are_not_saved():
    scene_graph, (a0, _, b0, _) = scene_with_two_balls()
    before = save_scene(scene_graph)
    manager = scene_graph.collision_filter_manager()
    manager.ApplyTransient(CollisionFilterDeclaration().ExcludeWithin(GeometrySet([a0, b0])))
    assert save_scene(scene_graph) == before


def test_poses_of_frames_are_saved_where_they_are_given():
    scene_graph, (a0, *_) = scene_with_two_balls()
    inspector = scene_graph.model_inspector()
    frame_id = inspector.GetFrameId(a0)
    X_PF = RigidTransform(RollPitchYaw(1, 2, 3), [1, 2, 3])
    loaded = load_scene(save_scene(scene_graph, {frame_id: X_PF}), SceneGraph())
    assert list(loaded.X_PFs) == [loaded.frames['s', 'a']]
    assert loaded.X_PFs[loaded.frames['s', 'a']].IsExactlyEqualTo(X_PF)


def test_a_frame_called_as_the_world_cannot_be_saved():
    scene_graph = SceneGraph()
    scene_graph.RegisterFrame(scene_graph.RegisterSource('s'), GeometryFrame('world'))
    with pytest.raises(SceneFileError, match=r"source 's' has a frame 'world'.*RenameFrame"):
        describe(scene_graph)


def test_what_is_static_and_what_is_expected_to_move_is_saved_and_read():
    scene_graph, (a0, _, b0, _) = scene_with_two_balls()
    a, b = map(scene_graph.model_inspector().GetFrameId, (a0, b0))
    text = to_yaml(describe(scene_graph, static={a: True, b: False}))
    loaded = load_scene(text, SceneGraph())
    assert loaded.static == {loaded.frames['s', 'a']: True, loaded.frames['s', 'b']: False}
    assert load_scene(save_scene(scene_graph), SceneGraph()).static == {}


def test_a_large_mesh_in_memory_loads_again():
    """120 000 vertices were written as a list of which the reader takes 100 000 items."""
    angles = np.linspace(0.0, 6.0, 120_000)
    vertices = np.column_stack((np.cos(angles), np.sin(angles), angles))
    triangles = np.arange(119_997).reshape(-1, 3)
    graph = SceneGraph()
    mesh = Mesh.FromMeshData(MeshData(vertices, triangles), 2.0)
    instance = GeometryInstance(RigidTransform(), mesh, 'coil')
    instance.set_illustration_properties(IllustrationProperties())
    graph.RegisterAnchoredGeometry(graph.RegisterSource('s'), instance)
    (shape,) = (g.shape for g in read_scene(save_scene(graph)).geometries)
    assert shape == mesh
    np.testing.assert_array_equal(shape.mesh_data().vertices, vertices)


@pytest.mark.parametrize(
    ('limit', 'word'),
    [('MAX_BYTES', 'bytes'), ('MOST_ITEMS', 'items'), ('MOST_VALUES', 'values')],
)
def test_what_would_not_load_again_is_not_saved(monkeypatch, limit, word):
    graph = SceneGraph()
    source = graph.RegisterSource('s')
    for k in range(20):
        graph.RegisterFrame(source, GeometryFrame(f'frame {k}'))
    text = save_scene(graph)
    read_scene(text)
    monkeypatch.setattr(yaml_writer, limit, 15)
    with pytest.raises(SceneFileError, match=f'cannot be saved: .*{word}'):
        save_scene(graph)


def test_a_file_of_too_many_values_is_refused_while_it_is_read(monkeypatch):
    monkeypatch.setattr(yaml_text, 'MOST_VALUES', 10)
    with pytest.raises(SceneFileError, match=r':4: .*more than 10 values in one file'):
        read_scene('frames:\n' + '- {name: a, group: 1}\n' * 9)


def test_a_packed_mesh_that_is_none_is_refused():
    text = 'geometries:\n- {{name: g, shape: {{type: mesh, vertices: "{}"}}}}'
    for packed in ('????', 'AAAA'):
        with pytest.raises(SceneFileError, match=r'geometries\[0\].shape: .*base64'):
            read_scene(text.format(packed))
