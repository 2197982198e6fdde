"""Models of MuJoCo: bodies, poses, candidate pairs and distances of MuJoCo itself."""

import re

import numpy as np
import pytest
import trimesh

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.scene_files import load_scene, read_scene, register, save_scene
from drake_geom_ros.scene_files.errors import SceneFileError

mujoco = pytest.importorskip('mujoco', exc_type=ImportError)
from oracles.like_mujoco import compared  # noqa: E402

BALL = '<geom type="sphere" size="0.1"/>'
SEEN = '<geom size="0.1" contype="0" conaffinity="0"/>'


def mjcf(bodies, more=''):
    return f'<mujoco model="m">{more}<worldbody>{bodies}</worldbody></mujoco>'


def body(name, inside='', joints='', pos='0.5 0 0'):
    return f'<body name="{name}" pos="{pos}" euler="10 20 30">{joints}{BALL}{inside}</body>'


def chain(*joints):
    inside = ''
    for k in reversed(range(len(joints))):
        inside = body(f'b{k}', inside, joints[k])
    return inside


HINGE = '<joint name="{}" type="hinge" axis="0 1 1" pos="0.1 0.2 0.3"/>'
SLIDE = '<joint name="{}" type="slide" axis="1 2 0"/>'
PLAIN = '<joint name="{}" axis="0 0 1" range="-90 45" limited="true"/>'
CASES = {
    'fixed bodies': mjcf(chain('', '')),
    'hinges': mjcf(chain(PLAIN.format('a'), HINGE.format('b'))),
    'slides': mjcf(chain(SLIDE.format('a'), SLIDE.format('b'))),
    'a ball': mjcf(chain('<joint name="a" type="ball" pos="0 0 0.2"/>', HINGE.format('b'))),
    'a free body': mjcf(chain('<freejoint name="a"/>', HINGE.format('b'))),
    'a mocap body': mjcf(f'<body name="a" mocap="true" pos="1 2 3">{BALL}</body>' + chain('')),
    'several joints': mjcf(chain(HINGE.format('a') + SLIDE.format('b') + PLAIN.format('c'), '')),
    'joints without names': mjcf(chain('<joint/>', '<joint type="slide"/>')),
    'references': mjcf(
        chain(
            '<joint name="a" axis="1 1 0" pos="0 0.1 0" ref="30"/>',
            '<joint name="b" type="slide" axis="0 1 0" ref="0.3"/>',
        )
    ),
    'a floor': mjcf('<geom type="plane" size="1 1 1"/>' + chain(HINGE.format('a'))),
    'a post': mjcf(BALL + chain('', HINGE.format('a'), '')),
    'defaults and frames': mjcf(
        '<frame pos="0 0 1" euler="0 90 0">' + chain(HINGE.format('a')) + '</frame>',
        '<default><geom size="0.2" contype="2"/></default>',
    ),
    'replicates': mjcf(
        '<replicate count="4" euler="0 0 30" offset="0 0 0.3">'
        + BALL
        + '</replicate><body name="b"><joint/><geom size="0.1"/></body>'
    ),
    'bits': mjcf(
        '<body><joint/><geom name="a" size="0.1" contype="1" conaffinity="2"/></body>'
        '<body><joint/><geom name="b" size="0.1" contype="2" conaffinity="0"/></body>'
        '<body><joint/><geom name="c" size="0.1" contype="0" conaffinity="1"/></body>'
        '<body><joint/><geom name="d" size="0.1" contype="0" conaffinity="1"/></body>'
        '<body><joint/><geom name="seen" size="0.1" contype="0" conaffinity="0"/></body>'
    ),
    'an exclusion': mjcf(
        chain(HINGE.format('a'), HINGE.format('b'), HINGE.format('c')),
        '<contact><exclude body1="b0" body2="b2"/></contact>',
    ),
    'a pair': mjcf(
        '<body name="x"><joint/><geom name="g" size="0.1"/><body name="y"><joint/>'
        '<geom name="h" size="0.1" contype="0" conaffinity="0"/></body></body>',
        '<contact><pair geom1="g" geom2="h"/></contact>',
    ),
    'no filter of parents': mjcf(
        chain(HINGE.format('a'), HINGE.format('b')),
        '<option><flag filterparent="disable"/></option>',
    ),
    'welded bodies': mjcf(chain(HINGE.format('a'), '', HINGE.format('b'), '')),
    'all shapes': mjcf(
        ''.join(
            f'<body pos="{k} 0 0"><joint/><geom type="{kind}" size="0.1 0.2 0.3"/></body>'
            for k, kind in enumerate(('sphere', 'capsule', 'cylinder', 'ellipsoid', 'box'))
        )
    ),
    'a mesh': mjcf(
        '<body><joint/><geom type="mesh" mesh="m" pos="0 0 1" euler="0 90 0"/></body>'
        '<body pos="3 0 0"><joint/><geom type="box" size="0.1 0.2 0.3"/></body>',
        '<asset><mesh name="m" scale="1 2 3" vertex="0 0 0 0.3 0 0 0 0.4 0 0 0 0.5"/></asset>',
    ),
    'two names of one': mjcf('<body name="body_2"><joint/><geom size="1"/></body><body/>'),
    'a world alone': mjcf(BALL),
}


@pytest.mark.parametrize('text', CASES.values(), ids=CASES.keys())
def test_models_are_those_of_mujoco(text):
    assert not compared(mujoco.MjModel.from_xml_string(text), read_scene(text + '\n'))


def test_what_mujoco_warns_of_is_a_warning_and_no_log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = mjcf(chain('<joint/>'), '<compiler settotalmass="1"/>')
    assert re.search(r'<text>: MuJoCo warns: .*settotalmass', read_scene(text + '\n').warnings[0])
    assert [*tmp_path.iterdir()] == []


def test_files_are_read_with_their_includes_and_meshes(tmp_path):
    trimesh.creation.box((0.2, 0.3, 0.4)).export(tmp_path / 'block.stl')
    (tmp_path / 'assets.xml').write_text(
        '<mujocoinclude><asset><mesh name="m" file="block.stl"/></asset></mujocoinclude>'
    )
    path = tmp_path / 'scene.xml'
    path.write_text(mjcf('<geom type="mesh" mesh="m"/>', '<include file="assets.xml"/>'))
    assert not compared(mujoco.MjModel.from_xml_path(str(path)), read_scene(path))
    (robot,) = read_scene(path).robots
    assert robot.urdf == path
    with pytest.raises(SceneFileError, match='load the model that includes it'):
        read_scene(tmp_path / 'assets.xml')


def test_shapes_have_the_sizes_of_mujoco():
    text = mjcf(
        '<geom type="plane" size="1 1 1"/>'
        + ''.join(
            f'<geom type="{kind}" size="0.1 0.2 0.3"/>'
            for kind in ('sphere', 'capsule', 'cylinder', 'ellipsoid', 'box')
        )
        + '<geom type="mesh" mesh="m"/>',
        '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>',
    )
    shapes = [geometry.shape for geometry in read_scene(text + '\n').geometries]
    kinds = [HalfSpace, Sphere, Capsule, Cylinder, Ellipsoid, Box, Mesh]
    assert [type(shape) for shape in shapes] == kinds
    assert (shapes[2].radius(), shapes[2].length()) == (0.1, 0.4)
    assert (shapes[3].radius(), shapes[3].length()) == (0.1, 0.4)
    assert (shapes[5].width(), shapes[5].depth(), shapes[5].height()) == (0.2, 0.4, 0.6)


def test_joints_have_limits_and_free_bodies_their_poses():
    scene = read_scene(
        mjcf(chain(PLAIN.format('a'), '') + body('f', joints='<freejoint/>')) + '\n'
    )
    joint = scene.robots[0].tree.joints[0]
    assert (joint.name, joint.type) == ('a', 'revolute')
    assert (joint.lower, joint.upper) == pytest.approx((-1.5707963, 0.78539816))
    poses = {frame.name: frame.X_PF for frame in scene.frames}
    assert poses['b0'] is None
    assert poses['f'].translation().tolist() == [0.5, 0.0, 0.0]


def test_bodies_that_are_fixed_to_the_world_are_anchored():
    scene_graph = SceneGraph()
    loaded = load_scene(mjcf(chain('', PLAIN.format('a'))) + '\n', scene_graph)
    welded = scene_graph.collision_filter_manager().welded_frames()
    assert welded == [loaded.frames['m', 'b0']]


def test_a_saved_scene_has_the_model_again(tmp_path):
    path = tmp_path / 'scene.xml'
    path.write_text(CASES['several joints'])
    first = SceneGraph()
    loaded = load_scene(path, first)
    saved = save_scene(first, loaded.X_PFs, loaded.robots.values())
    again = register(SceneGraph(), read_scene(saved))
    assert again.robots['m'].tree == loaded.robots['m'].tree
    assert [*again.frames] == [*loaded.frames]


@pytest.mark.parametrize(
    ('text', 'warning'),
    [
        (mjcf('<geom size="1" margin="0.1"/>'), r'<text>: 1 geometries have a margin'),
        (
            mjcf(BALL, '<option><flag contact="disable"/></option>'),
            r'contacts are disabled by a flag in MuJoCo',
        ),
        (mjcf(BALL, '<keyframe><key/></keyframe>'), r'1 keyframes are not read'),
        (
            mjcf(f'<body name="seen">{SEEN}</body><body name="hit">{BALL}</body>'),
            r'<text>: 1 of 2 links have visuals and no collision geometry, .*: seen\.',
        ),
        (
            mjcf(SEEN),
            r'<text>: no geometry of the model collides with anything',
        ),
    ],
)
def test_what_counts_in_mujoco_alone_is_reported(text, warning):
    assert re.search(warning, '\n'.join(read_scene(text + '\n').warnings))


@pytest.mark.parametrize(
    ('text', 'fault'),
    [
        (mjcf('<geom/>'), r'<text>: MuJoCo refuses it: .*size'),
        (mjcf('<thing/>'), r'MuJoCo refuses it: .*thing'),
        (
            mjcf(
                '<flexcomp name="f" type="grid" count="3 3 1" spacing="1 1 1" mass="1" dim="2"/>'
            ),
            r'1 flexible bodies',
        ),
    ],
)
def test_what_is_refused_is_named(text, fault):
    with pytest.raises(SceneFileError, match=fault):
        read_scene(text + '\n')


def test_a_text_that_others_send_may_not_open_files(tmp_path):
    with pytest.raises(SceneFileError, match='files of your own only'):
        read_scene(mjcf(BALL) + '\n', allowed_roots=[tmp_path])


def test_without_mujoco_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__('sys').modules, 'mujoco', None)
    with pytest.raises(SceneFileError, match=r"pip install 'drake_geom_ros\[mujoco\]'"):
        read_scene(mjcf(BALL) + '\n')


def test_height_fields_have_the_surface_that_rays_of_mujoco_hit():
    """Rows run along y, and each cell is cut along the same edge."""
    text = mjcf(
        '<geom type="hfield" hfield="h" pos="0.1 0.2 0.3"/>',
        '<asset><hfield name="h" nrow="3" ncol="4" size="1.5 1 0.8 0.2" '
        'elevation="0 0.2 0.9 0.3 0.7 0 0.4 1 0.1 0.6 0.5 0.2"/></asset>',
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    scene_graph = SceneGraph()
    register(scene_graph, read_scene(text + '\n'))
    query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
    rng = np.random.default_rng(1)
    hits = []
    for x, y in rng.uniform([-1.3, -0.7], [1.5, 1.1], (60, 2)):
        start = np.array([x, y, 5.0])
        geom = np.zeros(1, dtype=np.int32)
        reach = mujoco.mj_ray(model, data, start, np.array([0.0, 0, -1]), None, 1, -1, geom)
        hits.append(start - [0, 0, reach])
    distances = query.ComputeSignedDistanceToPoint(np.array(hits)).distance
    np.testing.assert_allclose(distances, 0.0, rtol=0.0, atol=1e-7)  # its data is of float32
    below = np.array([[0.1, 0.2, 0.3 - 0.2 - 0.1]])
    assert query.ComputeSignedDistanceToPoint(below).distance[0] == pytest.approx(0.1, abs=1e-12)
