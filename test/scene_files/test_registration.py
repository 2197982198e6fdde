from pathlib import Path

import pytest

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometrySet,
    Role,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.registration import register
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.saving import describe
from drake_geom_ros.scene_files.scene_file import load_scene, read_scene
from drake_geom_ros.scene_files.yaml_scene import parse_scene
from drake_geom_ros.scene_files.yaml_text import read_yaml
from drake_geom_ros.scene_files.yaml_writer import to_yaml

SCENE = """
sources: [robot, room]
frames:
- {name: arm, source: robot, group: 3, pose: {position: [0, 0, 1]}}
- {name: hand, source: robot, parent: arm}
geometries:
- {name: rod, source: robot, frame: arm, shape: {type: sphere, radius: 0.1}}
- {name: palm, source: robot, frame: hand, shape: {type: sphere, radius: 0.2}}
- {name: palm, source: robot, frame: hand, shape: {type: sphere, radius: 0.3},
   roles: {illustration: {phong: {diffuse: {rgba: [1, 0, 0, 1]}},
                          renderer: {accepting: {set: [vtk, gl]}}}}}
- {name: floor, source: room, shape: {type: half_space}}
"""


def parse(text):
    return parse_scene(read_yaml(text, 'a.yaml'), Path('/'), ResourceResolver())


def load(text, scene_graph):
    return register(scene_graph, parse(text))


def filtered(scene_graph, loaded, a, b):
    ids = (loaded.geometries[a], loaded.geometries[b])
    return scene_graph.model_inspector().CollisionFiltered(*ids)


ROD, PALM = ('robot', 'arm', 'rod'), ('robot', 'hand', 'palm')
FLOOR = ('room', 'world', 'floor')


def test_everything_is_registered_and_found_by_name():
    scene_graph = SceneGraph()
    loaded = load(SCENE, scene_graph)
    inspector = scene_graph.model_inspector()
    assert [inspector.GetName(id) for id in loaded.sources.values()] == ['robot', 'room']
    arm, hand = loaded.frames['robot', 'arm'], loaded.frames['robot', 'hand']
    assert inspector.GetParentFrame(hand) == arm
    assert inspector.GetParentFrame(arm) == inspector.world_frame_id()
    assert inspector.GetFrameGroup(arm) == 3
    assert set(loaded.geometries) == {ROD, PALM, FLOOR}
    assert inspector.GetFrameId(loaded.geometries[FLOOR]) == inspector.world_frame_id()
    assert inspector.GetShape(loaded.geometries[PALM]) == Sphere(0.2)
    assert len(loaded.geometry_ids) == 4
    drawn = loaded.geometry_ids[2]
    assert inspector.GetProximityProperties(drawn) is None
    properties = inspector.GetIllustrationProperties(drawn)
    assert properties.HasProperty('phong', 'diffuse')
    assert properties.GetProperty('renderer', 'accepting') == {'vtk', 'gl'}
    assert list(loaded.X_PFs) == [arm]
    assert loaded.X_PFs[arm].translation().tolist() == [0, 0, 1]


def test_ids_ascend_in_the_order_of_the_file():
    loaded = load(SCENE, SceneGraph())
    for ids in (loaded.sources.values(), loaded.frames.values(), loaded.geometry_ids):
        assert list(ids) == sorted(ids)


@pytest.mark.parametrize(
    ('said', 'pairs'),
    [
        ('- clique: {name: c, members: [arm, hand]}', {(ROD, PALM)}),
        ('- clique: {name: c, members: [arm/rod, hand, world]}',
         {(ROD, PALM), (ROD, FLOOR), (PALM, FLOOR)}),
        ('- group: {name: g, members: [arm], ignores: [h]}\n'
         '- group: {name: h, members: [world]}', {(ROD, FLOOR)}),
        ('- group: {name: g, members: [arm], ignores: [nobody]}', set()),
        ('- group: {name: g, members: [arm], ignores: [universal]}', {(ROD, PALM), (ROD, FLOOR)}),
        ('- exclude_within: [arm, hand]', {(ROD, PALM)}),
        ('- exclude_between: [[arm], [hand, world]]', {(ROD, PALM), (ROD, FLOOR)}),
        ('- exclude_within: [arm, hand]\n- allow_within: [arm, hand]', set()),
        ('- declaration: [{exclude_between: [[arm], [hand, world]]}, '
         '{allow_between: [[arm], [world]]}]', {(ROD, PALM)}),
        ('- clique: {name: c, members: [arm, hand]}\n- allow_between: [[arm], [hand]]', set()),
        ('- allow_between: [[arm], [hand]]\n- clique: {name: c, members: [arm, hand]}',
         {(ROD, PALM)}),
        ('- deactivate: [world/floor]', {(ROD, FLOOR), (PALM, FLOOR)}),
    ],
)  # fmt: skip
def test_filters_mean_what_they_say(said, pairs):
    scene_graph = SceneGraph()
    loaded = load(f'{SCENE}filters:\n{said}', scene_graph)
    for pair in ((ROD, PALM), (ROD, FLOOR), (PALM, FLOOR)):
        assert filtered(scene_graph, loaded, *pair) == (pair in pairs), pair


def test_explanations_name_what_the_file_names():
    scene_graph = SceneGraph()
    said = (
        '- clique: {name: c, members: [arm, hand]}\n- group: {name: g, members: [arm], '
        'ignores: [h]}\n- group: {name: h, members: [hand]}\n- exclude_within: [arm, hand]'
    )
    loaded = load(f'{SCENE}filters:\n{said}', scene_graph)
    manager = scene_graph.collision_filter_manager()
    reasons = manager.explain(loaded.geometries[ROD], loaded.geometries[PALM])
    assert reasons == ['persistent declaration 0', 'group g', 'clique c']


REFUSED = [
    ('frames: [{name: f}, {name: f}]', 'a.yaml:1: frames[1]: '),
    ('frames: [{name: f}]\nsources: [room]', 'a.yaml: source room: '),
    ('frames:\n- {name: f, parent: g}\n- {name: g}',
     "a.yaml:2: frames[0]: source 'scene' has no frame 'g' so far; it has none, and there is"),
    ('frames:\n- {name: g}\n- {name: f, source: t, parent: g}',
     "a.yaml:3: frames[1]: source 't' has no frame 'g'"),
    ('frames:\n- {name: world}', "a.yaml:2: frames[0]: a frame cannot be called 'world'"),
    ('geometries:\n- {name: g, frame: f, shape: {type: half_space}}',
     "a.yaml:2: geometries[0]: source 'scene' has no frame 'f'"),
    ('geometries:\n- {name: g, shape: {type: half_space}}\n- {name: g, shape: {type: half_space}}',
     'a.yaml:3: geometries[1]: '),
    ('geometries:\n- {name: floor, shape: {type: half_space}}', 'a.yaml:2: geometries[0]: '),
    ('filters:\n- group: {name: universal, members: []}', 'a.yaml:2: filters[0].group: '),
]  # fmt: skip


@pytest.mark.parametrize(('text', 'message'), REFUSED)
def test_what_the_scene_graph_refuses_names_its_line_and_changes_nothing(text, message):
    scene_graph = SceneGraph()
    load(SCENE, scene_graph)
    before = to_yaml(describe(scene_graph))
    version = scene_graph.model_version()
    more = 'robots: []\n'
    with pytest.raises(SceneFileError) as caught:
        load(f'{text}\n{more}', scene_graph)
    assert str(caught.value).startswith(message)
    assert to_yaml(describe(scene_graph)) == before
    assert scene_graph.model_version() == version


def test_persistent_filters_are_refused_during_a_transient_history_as_a_whole():
    scene_graph = SceneGraph()
    loaded = load(SCENE, scene_graph)
    manager = scene_graph.collision_filter_manager()
    both = GeometrySet([loaded.geometries[ROD], loaded.geometries[PALM]])
    manager.ApplyTransient(CollisionFilterDeclaration().ExcludeWithin(both))
    before = to_yaml(describe(scene_graph))
    frame = 'frames:\n- {name: f}\nfilters:\n'
    cliques = '- clique: {name: c, members: [f]}\n- clique: {name: d, members: [f]}'
    for text, message in (
        ('- exclude_within: [f]', 'a.yaml:4: filters[0].exclude_within: Apply: '),
        (cliques, 'a.yaml:4: filters[0].clique: AddClique: '),
    ):
        with pytest.raises(SceneFileError) as caught:
            load(frame + text, scene_graph)
        assert str(caught.value).startswith(message)
        assert to_yaml(describe(scene_graph)) == before
    load('frames:\n- {name: f}', scene_graph)


def test_contexts_begin_with_the_poses_of_the_file():
    scene_graph = SceneGraph()
    loaded = load(SCENE, scene_graph)
    arm, hand = loaded.frames['robot', 'arm'], loaded.frames['robot', 'hand']
    for context in (scene_graph.CreateDefaultContext(), scene_graph.CreateSharedContext()):
        query = scene_graph.get_query_output_port().Eval(context)
        assert query.waiting_frames() == [hand]
        context.UpdateFramePoses(FramePoseVector({hand: RigidTransform([1, 0, 0])}))
        assert query.X_WF(hand).translation().tolist() == [1, 0, 1]
        context.UpdateFramePoses(FramePoseVector({arm: RigidTransform()}))
        assert query.X_WF(hand).translation().tolist() == [1, 0, 0]


def test_a_context_that_exists_does_not_see_what_is_loaded_later():
    scene_graph = SceneGraph()
    context = scene_graph.CreateDefaultContext()
    load(SCENE, scene_graph)
    inspector = scene_graph.get_query_output_port().Eval(context).inspector()
    assert inspector.num_geometries() == 0
    assert scene_graph.model_inspector().NumGeometriesWithRole(Role.kProximity) == 3


GHOST = """<robot name="ghost">
<link name="a"><collision><geometry><sphere radius="1"/></geometry></collision></link>
<collision_filter_group name="{name}"><member link="a"/>
<ignored_collision_filter_group collision_filter_group="universal"/></collision_filter_group>
</robot>"""


def test_a_robot_that_ignores_the_universal_group_is_invisible_to_the_others():
    scene_graph = SceneGraph()
    room = load(SCENE, scene_graph)
    ghost = load_scene(GHOST.format(name='ghosts'), scene_graph)
    manager = scene_graph.collision_filter_manager()
    ids = ghost.geometries['ghost', 'a', 'collision_0'], room.geometries[FLOOR]
    assert manager.explain(*ids) == ['group ghost::ghosts']


def test_nobody_defines_the_universal_group():
    with pytest.raises(SceneFileError, match=r"<text>:3: .*'universal' is the group that all"):
        load_scene(GHOST.format(name='universal'), SceneGraph())


def test_what_was_welded_to_make_a_solid_is_among_the_warnings(tmp_path):
    """A tetrahedron of which each face has corners of its own, a last digit apart."""
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    lines = [
        f'v {corners[v][0] + 1e-10 * k} {corners[v][1]} {corners[v][2]}'
        for k, face in enumerate(faces)
        for v in face
    ]
    lines += [f'f {3 * k + 1} {3 * k + 2} {3 * k + 3}' for k in range(4)]
    (tmp_path / 'part.obj').write_text('\n'.join(lines))
    shape = '{type: mesh, uri: part.obj}'
    for solid, count in (('true', 1), ('false', 0)):
        roles = f'roles: {{proximity: {{mesh: {{solid: {solid}}}}}}}'
        scene = tmp_path / f'{solid}.yaml'
        scene.write_text(f'geometries:\n- {{name: part, shape: {shape}, {roles}}}\n')
        loaded = register(SceneGraph(), read_scene(str(scene)))
        assert len(loaded.warnings) == count
        assert all('world/part: 8 of its vertices were welded' in w for w in loaded.warnings)
