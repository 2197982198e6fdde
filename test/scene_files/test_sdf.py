"""SDFormat: meaning as in pydrake's parser or the specification, and refusals with their lines."""

import math
import re

import numpy as np
import pytest
import trimesh
from oracles.like_drake import compared

from drake_geom_ros.geometry import Convex, HalfSpace, Mesh, Role, SceneGraph
from drake_geom_ros.scene_files import load_scene, read_scene, register, save_scene
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.trajectories.kinematics import Kinematics

SHAPE = '<geometry><sphere><radius>0.2</radius></sphere></geometry>'
POSE = '<pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>'


def link(name, inside='', pose=''):
    return f'<link name="{name}">{pose}<collision name="c">{SHAPE}</collision>{inside}</link>'


def joint(kind, inside='', name='j', ends=('a', 'b')):
    parent, child = ends
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f'{inside}</joint>'
    )


def axis(xyz='0 0 1', inside='', tag='axis', attributes=''):
    return f'<{tag}><xyz{attributes}>{xyz}</xyz>{inside}</{tag}>'


def model(body, version='1.9', name='m', inside=''):
    return (
        f'<sdf version="{version}" xmlns:drake="http://drake.mit.edu"><model name="{name}">'
        f'{inside}{body}</model></sdf>'
    )


AB = link('a') + link('b', pose='<pose>1 0 0 0 0 0.5</pose>')
NESTED = '<model name="n"><pose>0 1 0 0.1 0 0</pose>' + AB + joint('revolute', axis()) + '</model>'
GROUP = '<drake:collision_filter_group name="{}">{}</drake:collision_filter_group>'
MEMBER = '<drake:member>{}</drake:member>'
IGNORED = '<drake:ignored_collision_filter_group>{}</drake:ignored_collision_filter_group>'
CASES = {
    'two free links': model(AB),
    'a pose of the model': model(AB, inside=POSE),
    'poses of links': model(link('a', pose=POSE) + link('b', pose='<pose/>')),
    'a pose in another frame': model(
        link('a', pose=POSE) + link('b', pose='<pose relative_to="a">1 0 0 0 0.3 0</pose>')
    ),
    'a pose in degrees': model(link('a', pose='<pose degrees="true">0 0 0 10 20 30</pose>')),
    'a pose with a quaternion': model(
        link('a', pose='<pose rotation_format="quat_xyzw">1 2 3 0 0 0.6 0.8</pose>')
    ),
    'frames': model(
        AB
        + f'<frame name="f" attached_to="b">{POSE}</frame>'
        + '<frame name="g" attached_to="f"><pose relative_to="a">0 0 1 0 0 0</pose></frame>'
        + link('c', pose='<pose relative_to="g">0 0 0 1 0 0</pose>')
    ),
    'a pose of a collision in a frame': model(
        AB + f'<frame name="f" attached_to="b">{POSE}</frame><link name="c"><collision name="k">'
        f'<pose relative_to="f">0 0 0.5 0 0 0</pose>{SHAPE}</collision></link>'
    ),
    **{
        f'a {kind} joint': model(AB + joint(kind, axis('0 1 1')))
        for kind in ('revolute', 'continuous', 'prismatic', 'ball', 'fixed')
    },
    **{
        f'a {kind} joint with a pose': model(AB + joint(kind, POSE + axis('0 1 1')))
        for kind in ('revolute', 'prismatic', 'ball', 'fixed')
    },
    'a joint posed in the parent': model(
        AB + joint('revolute', '<pose relative_to="a">0.5 0 0 0 0 0</pose>' + axis())
    ),
    'a universal joint': model(
        AB + joint('universal', POSE + axis('1 0 0') + axis('0 1 0', tag='axis2'))
    ),
    'a screw joint': model(
        AB + joint('screw', POSE + axis() + '<screw_thread_pitch>0.4</screw_thread_pitch>')
    ),
    'a screw joint with threads': model(
        AB + joint('screw', axis() + '<thread_pitch>-20</thread_pitch>')
    ),
    'limits': model(
        AB + joint('revolute', axis(inside='<limit><lower>-0.1</lower><upper>0.2</upper></limit>'))
    ),
    'an axis in the frame of the model': model(
        AB + joint('revolute', POSE + axis('1 0 0', attributes=' expressed_in="__model__"'))
    ),
    'an axis in a frame': model(
        AB
        + f'<frame name="f" attached_to="a">{POSE}</frame>'
        + joint('revolute', axis('1 0 0', attributes=' expressed_in="f"'))
    ),
    'an axis of version 1.4': model(AB + joint('revolute', axis('1 0 0')), version='1.4'),
    'an axis of version 1.6': model(AB + joint('revolute', axis('1 0 0')), version='1.6'),
    'an axis in the model of version 1.6': model(
        AB
        + joint(
            'revolute', axis('1 0 0', '<use_parent_model_frame>true</use_parent_model_frame>')
        ),
        version='1.6',
    ),
    'a joint to the world': model(
        AB + joint('revolute', axis(), ends=('world', 'b')), inside=POSE
    ),
    'a fixed joint to the world': model(AB + joint('fixed', ends=('world', 'b')), inside=POSE),
    'a joint by frames': model(
        AB
        + f'<frame name="f" attached_to="a">{POSE}</frame>'
        + '<frame name="g" attached_to="b"><pose>0 0 1 0 0 0</pose></frame>'
        + joint('revolute', axis(), ends=('f', 'g'))
    ),
    "Drake's planar joint": model(
        AB
        + '<drake:joint name="j" type="planar"><drake:parent>a</drake:parent>'
        + '<drake:child>b</drake:child><drake:damping>0 0 0</drake:damping></drake:joint>'
    ),
    'a chain': model(
        AB
        + link('c')
        + joint('revolute', POSE + axis())
        + joint('prismatic', POSE + axis(), name='k', ends=('b', 'c'))
    ),
    'a static model': model(AB + joint('fixed'), inside='<static>true</static>' + POSE),
    'a nested model': model(link('a') + NESTED, inside=POSE),
    'a joint into a nested model': model(
        link('a') + NESTED + joint('revolute', axis(), name='k', ends=('a', 'n::a'))
    ),
    'a pose in a nested model': model(
        NESTED + link('c', pose='<pose relative_to="n::b">0 0 1 0 0 0</pose>')
    ),
    'a placement frame': model(
        '<frame name="f" attached_to="a"><pose>0 0 1 0 0 0</pose></frame>' + AB, inside=POSE
    ).replace('<model name="m">', '<model name="m" placement_frame="f">'),
    'all shapes': model(
        '<link name="a">'
        + ''.join(
            f'<collision name="{k}"><pose>{k} 0 0 0 0.1 0</pose><geometry>{shape}</geometry>'
            '</collision>'
            for k, shape in enumerate(
                (
                    '<box><size>1 2 3</size></box>',
                    '<sphere><radius>0.3</radius></sphere>',
                    '<cylinder><radius>0.3</radius><length>2</length></cylinder>',
                    '<capsule><radius>0.3</radius><length>2</length></capsule>',
                    '<ellipsoid><radii>1 2 3</radii></ellipsoid>',
                    '<drake:capsule><radius>0.3</radius><length>2</length></drake:capsule>',
                    '<drake:ellipsoid><a>1</a><b>2</b><c>3</c></drake:ellipsoid>',
                    '<mesh><uri>block.obj</uri><scale>1 2 3</scale></mesh>',
                    '<mesh><uri>block.obj</uri><drake:declare_convex/></mesh>',
                    '<plane><normal>0 1 1</normal><size>1 1</size></plane>',
                    '<empty/>',
                )
            )
        )
        + '</link>'
    ),
    'a filter group': model(
        AB + GROUP.format('g', MEMBER.format('a') + MEMBER.format('b') + IGNORED.format('g'))
    ),
    'an ignored filter group': model(
        AB
        + GROUP.format('g', MEMBER.format('a') + MEMBER.format('b') + IGNORED.format('g')).replace(
            'name="g"', 'name="g" ignore="true"'
        )
    ),
    'groups of nested models': model(
        link('x')
        + NESTED.replace('</model>', GROUP.format('g', MEMBER.format('a')) + '</model>')
        + GROUP.format(
            'h',
            MEMBER.format('x')
            + IGNORED.format('n::g')
            + IGNORED.format('h')
            + '<drake:member_group>n::g</drake:member_group>',
        )
    ),
    'mimicry of Drake': model(
        AB
        + link('c')
        + joint('revolute', axis())
        + joint(
            'revolute',
            axis() + '<drake:mimic joint="j" multiplier="2" offset="0.1"/>',
            name='k',
            ends=('b', 'c'),
        )
    ),
    'a world': '<sdf version="1.9"><world name="w"><model name="m">'
    + AB
    + joint('revolute', axis())
    + '</model><frame name="f"><pose>0 0 4 0 0 0</pose></frame>'
    + '<model name="o"><pose relative_to="f">0 0 1 0 0 0</pose>'
    + link('a')
    + '</model><joint name="w" type="fixed"><parent>m::b</parent><child>o::a</child></joint>'
    + '</world></sdf>',
    'an include': model(
        link('a')
        + f'<include><uri>package://parts/part.sdf</uri><name>p</name>{POSE}</include>'
        + '<include><uri>package://parts/part.sdf</uri></include>'
    ),
    'an include that merges': model(
        link('x', pose=POSE)
        + '<include merge="true"><uri>package://parts/part.sdf</uri>'
        + '<pose relative_to="x">1 0 0 0 0 0.5</pose></include>'
        + joint('revolute', axis(), name='k', ends=('x', 'a'))
    ),
    'an include by a placement frame': model(
        link('x', pose=POSE)
        + '<include><uri>package://parts/part.sdf</uri><placement_frame>b</placement_frame>'
        + '<pose relative_to="x">1 0 0 0 0 0.5</pose></include>'
    ),
}


@pytest.fixture
def parts(tmp_path):
    """The folder of the package ``parts``, which has a model, and a mesh."""
    folder = tmp_path / 'parts'
    folder.mkdir()
    (folder / 'package.xml').write_text('<package><name>parts</name></package>')
    part = model(AB + joint('revolute', POSE + axis()), name='part', inside=POSE)
    (folder / 'part.sdf').write_text(part)
    (folder / 'model.config').write_text(
        '<model><name>parts</name><sdf version="1.2">older.sdf</sdf>'
        '<sdf version="1.9">part.sdf</sdf></model>'
    )
    trimesh.creation.box((0.2, 0.3, 0.4)).export(folder / 'block.obj')
    return folder


def written(folder, text):
    path = folder / 'scene.sdf'
    path.write_text(text)
    return path


@pytest.mark.parametrize('text', CASES.values(), ids=CASES.keys())
def test_models_are_those_of_pydrake(parts, text):
    pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    assert not compared(written(parts, text), [parts])


def geometries_of(text):
    return read_scene(text + '\n').geometries


def at_values(text, values):
    """Return X_WL by name of the only model at joint values."""
    (robot,) = read_scene(text + '\n').robots
    kinematics = Kinematics(robot.tree)
    X_WLs = kinematics.link_transforms(kinematics.at_rest(values))
    return dict(zip(kinematics.link_names, X_WLs, strict=True))


def test_a_joint_about_two_axes_turns_the_second_by_the_first():
    text = model(AB + joint('revolute2', axis('0 0 1') + axis('1 0 0', tag='axis2')))
    both = at_values(text, {'j/qx': math.pi / 2, 'j/qy': 0.3})['b']
    np.testing.assert_allclose(both[:3, 0], [-math.sin(0.5), math.cos(0.5), 0], rtol=0, atol=1e-15)


def test_a_joint_of_sdformat_1_11_follows_another_one():
    follower = axis(
        inside='<mimic joint="j"><multiplier>2</multiplier><offset>0.1</offset>'
        '<reference>0.5</reference></mimic>'
    )
    text = model(
        AB + link('c') + joint('revolute', axis()) + joint('revolute', follower, 'k', ('b', 'c')),
        version='1.11',
    )
    (robot,) = read_scene(text + '\n').robots
    mimic = robot.tree.joints[1].mimic
    assert (mimic.joint, mimic.multiplier, mimic.offset) == ('j', 2.0, 0.1 - 2.0 * 0.5)


def test_links_below_a_moving_joint_wait_for_its_value(parts):
    scene = read_scene(written(parts, model(AB + joint('revolute', axis()), inside=POSE)))
    poses = {frame.name: frame.X_PF for frame in scene.frames}
    assert poses['a'].translation().tolist() == [0.1, 0.2, 0.3]
    assert poses['b'] is None


def test_a_plane_is_a_half_space_and_a_static_model_is_anchored():
    text = model(
        '<link name="a"><collision name="c"><geometry><plane/></geometry></collision></link>',
        inside='<static>true</static>',
    )
    scene_graph = SceneGraph()
    loaded = load_scene(text, scene_graph)
    (geometry,) = loaded.geometry_ids
    assert isinstance(scene_graph.model_inspector().GetShape(geometry), HalfSpace)
    assert scene_graph.collision_filter_manager().welded_frames() == [*loaded.frames.values()]


def test_a_saved_scene_has_the_models_again(parts):
    text = CASES['a world']
    first = SceneGraph()
    loaded = load_scene(written(parts, text), first)
    saved = save_scene(first, loaded.X_PFs, loaded.robots.values())
    again = read_scene(saved)
    assert [robot.model for robot in again.robots] == ['m', 'o']
    assert [robot.tree for robot in again.robots] == [r.tree for r in loaded.robots.values()]
    assert save_scene(*_registered(again)) == saved


def _registered(scene):
    scene_graph = SceneGraph()
    loaded = register(scene_graph, scene)
    return scene_graph, loaded.X_PFs, loaded.robots.values()


def test_a_robot_of_a_scene_file_may_be_a_model_of_sdformat(parts):
    written(parts, CASES['a world'])
    path = parts / 'cell.yaml'
    path.write_text('robots:\n- {name: left, urdf: scene.sdf, model: o}\n')
    scene = read_scene(path)
    assert scene.sources == ('left',)
    assert scene.frames[0].X_PF.translation().tolist() == [0.0, 0.0, 5.0]
    path.write_text('robots:\n- {name: left, urdf: scene.sdf}\n')
    with pytest.raises(SceneFileError, match='one model is wanted; there are m, o'):
        read_scene(path)


def test_meshes_are_hulls_or_convex(parts):
    kinds = ('<drake:declare_convex/>', '<scale>1 1 2</scale>')
    for inside, kind in zip(kinds, (Convex, Mesh), strict=True):
        text = model(
            '<link name="a"><collision name="c"><geometry><mesh><uri>block.obj</uri>'
            f'{inside}</mesh></geometry></collision></link>'
        )
        (geometry,) = read_scene(written(parts, text)).geometries
        assert isinstance(geometry.shape, kind)


@pytest.mark.parametrize(
    ('masks', 'is_reported'),
    [
        ((1, 2), False),
        ((1, 3), True),
        ((None, 4), True),
        ((0, None), False),
        ((0x10000, 1), False),
    ],
)
def test_bitmasks_that_share_no_bit_filter_a_pair(masks, is_reported):
    bodies = ''
    for name, mask in zip('ab', masks, strict=True):
        surface = (
            ''
            if mask is None
            else (
                f'<surface><contact><collide_bitmask>{mask}</collide_bitmask></contact></surface>'
            )
        )
        bodies += f'<link name="{name}"><collision name="c">{SHAPE}{surface}</collision></link>'
    scene_graph = SceneGraph()
    load_scene(model(bodies), scene_graph)
    inspector = scene_graph.model_inspector()
    assert bool(inspector.GetCollisionCandidates()) == is_reported


@pytest.mark.parametrize(('value', 'is_reported'), [('false', False), ('true', True), ('', True)])
def test_self_collide_filters_a_model_where_it_is_written(value, is_reported):
    scene_graph = SceneGraph()
    inside = value and f'<self_collide>{value}</self_collide>'
    load_scene(model(AB, inside=inside), scene_graph)
    assert bool(scene_graph.model_inspector().GetCollisionCandidates()) == is_reported


def test_properties_of_drake_are_kept():
    inside = (
        '<drake:proximity_properties><drake:compliant_hydroelastic/>'
        '<drake:hydroelastic_modulus>1e6</drake:hydroelastic_modulus></drake:proximity_properties>'
    )
    body = f'<link name="a"><collision name="c">{SHAPE}{inside}</collision></link>'
    (geometry,) = geometries_of(model(body))
    properties = geometry.roles[Role.kProximity]
    assert properties.GetProperty('hydroelastic', 'hydroelastic_modulus') == 1e6


def test_an_undeclared_prefix_is_declared_and_reported():
    text = model(
        '<link name="a"><collision name="c"><geometry><drake:capsule><radius>1</radius>'
        '<length>1</length></drake:capsule></geometry></collision></link>'
    ).replace(' xmlns:drake="http://drake.mit.edu"', '')
    scene = read_scene(text + '\n')
    assert len(scene.geometries) == 1
    assert re.search(r'<text>:1: .*prefix `drake:` is not declared', scene.warnings[0])


@pytest.mark.parametrize(
    ('text', 'warning'),
    [
        (model(AB + '<wheel/>'), r'<text>:1: model\[m\].wheel: <wheel> in <model> is not'),
        (model('<link name="a"/>'), r"the model 'm' has no <collision> elements"),
        (
            model(AB + f'<link name="c"><visual name="v">{SHAPE}</visual></link>'),
            r'<text>:1: .*1 of 3 links have visuals and no collision geometry, .*: c\.',
        ),
        (
            '<sdf version="1.9"><world name="w"><actor name="x"/><model name="m">'
            + link('a')
            + '</model></world></sdf>',
            r'<actor>: an actor moves by itself',
        ),
        (
            model(
                AB + '<drake:joint name="j" type="curvilinear"><drake:parent>a</drake:parent>'
                '<drake:child>b</drake:child></drake:joint>'
            ),
            r"no joint value moves this joint: send poses of 'b'",
        ),
    ],
)
def test_what_is_not_understood_is_reported(text, warning):
    warnings = '\n'.join(read_scene(text + '\n').warnings)
    assert re.search(warning, warnings), warnings


def shaped(shape):
    return model(
        f'<link name="a"><collision name="c"><geometry>{shape}</geometry></collision></link>'
    )


@pytest.mark.parametrize(
    ('text', 'fault'),
    [
        ('<sdf version="1.9"/>', r'neither a <model> nor a <world>'),
        ('<sdf version="2.0"><model name="m"/></sdf>', r"version '2.0'; known are 1.2 to 1.12"),
        ('<sdf version="1.13"><model name="m"/></sdf>', r'version 1.13; known'),
        (model(''), r"model\[m\]: the model 'm' has no links"),
        (model(AB + link('a')), r"link\[a\]: 'a' is the name of two elements"),
        (model(link('__root__')), r"the name '__root__' is reserved"),
        (model(link('a', pose='<pose relative_to="x"/>')), r"has no frame 'x'; there are a"),
        (
            model(
                link('a', pose='<pose relative_to="b"/>')
                + link('b', pose='<pose relative_to="a"/>')
            ),
            r'counts from itself',
        ),
        (model(link('a', pose='<pose>1 2 3</pose>')), r"'1 2 3'; it must be 6 finite numbers"),
        (
            model(AB + joint('gearbox', axis())),
            r"joint\[j\]: type 'gearbox' of a joint is not read",
        ),
        (model(AB + joint('revolute', axis('0 0 0'))), r'it has no direction'),
        (
            model(AB + joint('revolute', axis(), ends=('a', 'x'))),
            r"joint\[j\]: .*has no frame 'x'",
        ),
        (model(AB + joint('revolute', axis(), ends=('a', 'world'))), r"child 'world' must be"),
        (
            model(AB + joint('fixed') + joint('fixed', name='k', ends=('b', 'a'))),
            r'joints form a ring',
        ),
        (
            model(
                AB
                + joint('revolute', axis(inside='<limit><lower>1</lower><upper>0</upper></limit>'))
            ),
            r'lower = 1 is above upper = 0',
        ),
        (shaped('<heightmap/>'), r'<heightmap> has no <uri>'),
        (shaped('<polyline/>'), r'<polyline> has no <height>'),
        (
            shaped('<polyline><point>0 0</point><height>1</height></polyline>'),
            r'an outline of 1 points',
        ),
        (shaped('<cone/>'), r'<cone> is not read; give it as a mesh'),
        (shaped('<box><size>1 2</size></box>'), r"<size> is '1 2'; it must be 3 finite numbers"),
        (shaped('<sphere/>'), r'<sphere> has no <radius>'),
        (shaped('<mesh><uri>absent.obj</uri></mesh>'), r'absent.obj'),
        (model(AB + '<include><uri>https://x/y</uri></include>'), r"scheme 'https'; use package"),
        (model(AB + '<include/>'), r'<include> has no <uri>'),
        (
            model(AB + GROUP.format('g', MEMBER.format('x'))),
            r"link 'x' is not in the model",
        ),
        (
            '<sdf version="1.9"><world name="w"/><world name="v"/></sdf>',
            r'a second <world>',
        ),
        (
            '<sdf version="1.9"><world name="w"><model name="m">'
            + link('a')
            + '</model><model name="n">'
            + link('a')
            + '</model>'
            + joint('revolute', axis(), ends=('m::a', 'n::a'))
            + '</world></sdf>',
            r'between two models must be fixed',
        ),
    ],
)
def test_what_is_refused_is_named_with_its_line(text, fault):
    with pytest.raises(SceneFileError, match=fault) as caught:
        read_scene(text + '\n')
    assert caught.value.line == 1


def test_a_file_that_includes_itself_is_refused(parts):
    path = parts / 'self.sdf'
    path.write_text(model('<include><uri>self.sdf</uri></include>'))
    with pytest.raises(SceneFileError, match=r'nested more than 32 deep|includes itself'):
        read_scene(path)


def test_a_folder_of_a_model_is_included_by_its_latest_file(parts, monkeypatch):
    text = model('<include><uri>model://parts</uri></include>')
    by_folder = read_scene(written(parts, text)).frames
    assert [frame.name for frame in by_folder] == ['part::a', 'part::b']
    elsewhere = parts.parent / 'elsewhere'
    elsewhere.mkdir()
    monkeypatch.setenv('SDF_PATH', str(parts.parent))
    assert read_scene(written(elsewhere, text)).frames == by_folder
    (parts / 'model.config').unlink()
    with pytest.raises(SceneFileError, match=r'no file .*parts/model.sdf'):
        read_scene(written(parts, text))


def test_a_faulty_include_is_named_by_its_own_file(parts):
    (parts / 'bad.sdf').write_text(model('\n' + link('a', pose='<pose>x</pose>')))
    with pytest.raises(SceneFileError, match=r'bad.sdf:2: .*link\[a\]'):
        read_scene(written(parts, model('<include><uri>bad.sdf</uri></include>')))


def test_a_polyline_is_the_solid_of_its_outline():
    """A point in the notch of an arrow is out of it, and its hull would hold it."""
    points = ''.join(f'<point>{x} {y}</point>' for x, y in ((0, 0), (2, 1), (0, 2), (1, 1)))
    text = shaped(f'<polyline>{points}<height>0.5</height></polyline>')
    scene_graph = SceneGraph()
    register(scene_graph, read_scene(text))
    context = scene_graph.CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(context)
    at = np.array([[0.5, 1.0, 0.25], [1.5, 1.0, 0.6]])
    distances = query.ComputeSignedDistanceToPoint(at).distance
    np.testing.assert_allclose(distances, [0.5 / 2.0**0.5, 0.1], rtol=0.0, atol=1e-14)
    (geometry,) = read_scene(text).geometries
    (properties,) = geometry.roles.values()
    assert properties.GetProperty('mesh', 'solid') is True
