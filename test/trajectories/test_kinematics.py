import numpy as np
import pytest
import yourdfpy
from oracles import panda

from drake_geom_ros.scene_files import SceneFileError
from drake_geom_ros.trajectories.kinematics import Kinematics


@pytest.fixture(scope='module')
def arm():
    return Kinematics(str(panda.URDF))


def _random_q(arm, count):
    return np.random.default_rng(1).uniform(arm.lower, arm.upper, (count, len(arm.lower)))


def test_panda_agrees_with_its_denavit_hartenberg_table(arm):
    for q in _random_q(arm, 20):
        X_BLs = arm.link_transforms(q)
        for name, X_BL in panda.link_transforms(q).items():
            np.testing.assert_allclose(X_BLs[arm.link_names.index(name)], X_BL, rtol=0, atol=1e-12)


def test_panda_agrees_with_yourdfpy_one_by_one(arm):
    robot = yourdfpy.URDF.load(str(panda.URDF), load_meshes=False)
    for q in _random_q(arm, 3):
        robot.update_cfg(q)
        expected = [robot.get_transform(name, 'panda_link0') for name in arm.link_names]
        np.testing.assert_allclose(arm.link_transforms(q), expected, rtol=0, atol=1e-12)


def test_joints_limits_and_links_are_those_of_the_file(arm):
    assert arm.joint_names == (*(f'panda_joint{k}' for k in range(1, 8)), 'panda_finger_joint1')
    assert arm.link_names[0] == 'panda_link0'
    assert len(arm.link_names) == 13
    assert len(arm.joined_links) == 12
    assert ('panda_hand', 'panda_leftfinger') in arm.joined_links
    assert (arm.lower[3], arm.upper[3], arm.max_speed[3]) == (-3.0718, -0.0698, 2.175)


def test_values_beyond_those_of_the_tree_move_no_link(arm):
    needs = arm.tree.needs()
    assert needs.shape == (13, 8)
    assert needs[:, 0].tolist() == [False] + [True] * 12
    assert np.array_equal(arm.tree.needs(3), needs)
    wider = arm.tree.needs(10)
    assert np.array_equal(wider[:, :8], needs)
    assert not wider[:, 8:].any()
    assert wider.shape == (13, 10)


def test_a_batch_is_its_configurations_one_by_one_on_the_base(arm):
    q = _random_q(arm, 6).reshape(2, 3, -1)
    X_WB = np.array([[0.0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    X_WLs = arm.link_transforms(q, X_WB)
    assert X_WLs.shape == (2, 3, 13, 4, 4)
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(
            X_WLs[index], X_WB @ arm.link_transforms(q[index]), rtol=0, atol=1e-14
        )


def test_wrong_number_of_joints_is_refused(arm):
    with pytest.raises(ValueError, match='panda_finger_joint1'):
        arm.link_transforms(np.zeros(7))


def _urdf(tmp_path, *joints, links='abcd'):
    text = ''.join(f'<link name="{name}"/>' for name in links) + ''.join(joints)
    path = tmp_path / 'robot.urdf'
    path.write_text(f'<robot name="r">{text}</robot>')
    return str(path)


def _joint(name, kind, parent, child, inside=''):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/>{inside}</joint>'
    )


def test_joints_in_any_order_with_long_axes_and_chained_mimics(tmp_path):
    path = _urdf(
        tmp_path,
        _joint(
            'last',
            'prismatic',
            'c',
            'd',
            '<axis xyz="0 0 5"/><limit velocity="1"/><mimic joint="middle" multiplier="3"/>',
        ),
        _joint(
            'first',
            'revolute',
            'a',
            'b',
            '<axis xyz="0 0 2"/><limit lower="-1" upper="2" velocity="1" effort="1"/>',
        ),
        _joint(
            'middle',
            'continuous',
            'b',
            'c',
            '<origin xyz="1 0 0"/><axis xyz="0 1 0"/>'
            '<mimic joint="first" multiplier="-2" offset="0.5"/>',
        ),
    )
    robot = Kinematics(path)
    assert robot.joint_names == ('first',)
    assert robot.link_names == ('a', 'b', 'c', 'd')
    X = dict(zip(robot.link_names, robot.link_transforms([0.3]), strict=True))
    ct, st = np.cos(0.3), np.sin(0.3)
    np.testing.assert_allclose(X['c'][:3, 3], [ct, st, 0.0], rtol=0, atol=1e-15)
    way = 3 * (-2 * 0.3 + 0.5)
    tilt = -2 * 0.3 + 0.5
    direction = np.array([ct * np.sin(tilt), st * np.sin(tilt), np.cos(tilt)])
    np.testing.assert_allclose(X['d'][:3, 3] - X['c'][:3, 3], way * direction, rtol=0, atol=1e-15)


TREELESS = [
    ('ab', [_joint('j', 'fixed', 'a', 'b'), _joint('k', 'fixed', 'b', 'a')], 'form a ring'),
    ('abc', [_joint('j', 'fixed', 'b', 'c'), _joint('k', 'fixed', 'c', 'b')], 'form a ring'),
    ('abc', [_joint(n, 'fixed', n, 'b') for n in 'ac'], "'b' has two parents"),
    ('ab', [_joint('j', 'ball', 'a', 'b')], "type 'ball'"),
    ('ab', [_joint('j', 'planar', 'a', 'b', '<axis xyz="0 0 0"/>')], 'not be zero'),
    ('ab', [_joint('j', 'continuous', 'a', 'b', '<axis xyz="0 0 0"/>')], 'not be zero'),
]
COMPLICATED = [
    ('abcd', [_joint('j', 'fixed', 'a', 'b')], 'one tree'),
    (
        'abc',
        [
            _joint('j', 'fixed', 'a', 'b'),
            _joint('k', 'continuous', 'b', 'c', '<mimic joint="j"/>'),
        ],
        'a fixed joint',
    ),
    (
        'abc',
        [
            _joint('j', 'floating', 'a', 'b'),
            _joint('k', 'continuous', 'b', 'c', '<mimic joint="j"/>'),
        ],
        "mimics 'j', a floating joint",
    ),
    (
        'abc',
        [
            _joint('j', 'planar', 'a', 'b', '<mimic joint="k"/>'),
            _joint('k', 'continuous', 'b', 'c'),
        ],
        'is planar and mimics',
    ),
    (
        'abc',
        [_joint('j', 'floating', 'a', 'b'), _joint('j/x', 'continuous', 'b', 'c')],
        "'j/x' is a joint, and a value",
    ),
    ('ab', [_joint('j', 'continuous', 'a', 'b', '<mimic joint="x"/>')], 'not a joint'),
    ('ab', [_joint('j', 'continuous', 'a', 'b', '<mimic joint="j"/>')], 'itself'),
]


@pytest.mark.parametrize(('links', 'joints', 'reason'), COMPLICATED)
def test_what_is_no_tree_of_simple_joints_is_refused(tmp_path, links, joints, reason):
    with pytest.raises(ValueError, match=reason):
        Kinematics(_urdf(tmp_path, *joints, links=links))


@pytest.mark.parametrize(('links', 'joints', 'reason'), TREELESS)
def test_what_is_no_tree_is_refused_with_its_place(tmp_path, links, joints, reason):
    with pytest.raises(SceneFileError, match=rf'robot\.urdf:1: joint.*{reason}'):
        Kinematics(_urdf(tmp_path, *joints, links=links))


@pytest.mark.parametrize(
    'turn',
    [
        'rpy="0 0 1.5707963267948966"',
        'quat_xyzw="0 0 0.7071 0.7071"',
        'wxyz="0.7071 0 0 0.7071"',
    ],
)
def test_the_origin_of_a_joint_is_turned_as_it_says(tmp_path, turn):
    text = _joint('j', 'prismatic', 'a', 'b', f'<origin xyz="1 0 0" {turn}/><axis xyz="1 0 0"/>')
    X_WL = Kinematics(_urdf(tmp_path, text, links='ab')).link_transforms([0.0])[1]
    turned = [[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    np.testing.assert_allclose(X_WL, turned, rtol=0, atol=1e-12)


def test_capsules_of_newer_urdf_are_no_hindrance(tmp_path):
    shape = '<collision><geometry><capsule radius="0.1" length="0.3"/></geometry></collision>'
    path = tmp_path / 'robot.urdf'
    path.write_text(f'<robot name="r" version="1.1"><link name="a">{shape}</link></robot>')
    assert Kinematics(str(path)).link_names == ('a',)


BASE = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="base" type="{}"><parent link="a"/><child link="b"/>
<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="{}"/></joint>
<joint name="turn" type="continuous"><parent link="b"/><child link="c"/>
<origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint></robot>"""
VALUES = {'planar': [0.4, -0.7, 1.1], 'floating': [0.4, -0.7, 0.2, 1.1, 0.5, -0.3]}


def base(tmp_path, kind, axis='0 0 1'):
    path = tmp_path / 'base.urdf'
    path.write_text(BASE.format(kind, axis))
    return Kinematics(str(path))


@pytest.mark.parametrize('kind', VALUES)
def test_joints_of_several_values_stand_as_pydrakes(tmp_path, kind):
    plants = pytest.importorskip('pydrake.multibody.tree')
    from pydrake.math import RigidTransform, RollPitchYaw
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(1.0)
    inertia = plants.SpatialInertia.SolidSphereWithMass(1.0, 1.0)
    bodies = [plant.AddRigidBody(name, inertia) for name in 'abc']
    plant.WeldFrames(plant.world_frame(), bodies[0].body_frame())
    X_AJ = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1, 2, 3])
    make = plants.PlanarJoint if kind == 'planar' else plants.RpyFloatingJoint
    J = plant.AddFrame(plants.FixedOffsetFrame('J', bodies[0].body_frame(), X_AJ))
    ends = (J, bodies[1].body_frame())
    loose = plant.AddJoint(make('base', *ends))
    X_BK = RigidTransform([0.5, 0, 0])
    arm = plant.AddFrame(plants.FixedOffsetFrame('K', bodies[1].body_frame(), X_BK))
    plant.AddJoint(plants.RevoluteJoint('turn', arm, bodies[2].body_frame(), [0, 1, 0]))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q = VALUES[kind]
    if kind == 'planar':
        loose.set_translation(context, q[:2])
        loose.set_rotation(context, q[2])
    else:
        loose.SetTranslation(context, q[:3])
        loose.set_angles(context, [q[5], q[4], q[3]])
    plant.GetJointByName('turn').set_angle(context, 0.9)
    robot = base(tmp_path, kind)
    assert robot.joint_names[-1] == 'turn'
    expected = [plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4() for body in bodies]
    np.testing.assert_allclose(robot.link_transforms([*q, 0.9]), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize('axis', ['0 0 1', '0 0 -2', '0 -1 0', '1 2 -3'])
def test_a_planar_joint_moves_in_the_plane_of_its_axis(tmp_path, axis):
    robot = base(tmp_path, 'planar', axis)
    normal = np.array(axis.split(), dtype=float)
    normal /= np.linalg.norm(normal)
    X_Ws = robot.link_transforms([[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.3, 0]])[:, 1]
    R = X_Ws[0, :3, :3]
    along = [R.T @ (X[:3, 3] - X_Ws[0, :3, 3]) for X in X_Ws[1:3]]
    frame = np.array([*along, normal])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), rtol=0, atol=1e-12)
    assert np.linalg.det(frame) > 0
    turned = R.T @ X_Ws[3, :3, :3]
    np.testing.assert_allclose(turned @ normal, normal, rtol=0, atol=1e-12)
    np.testing.assert_allclose(turned @ along[0] @ along[1], np.sin(0.3), rtol=0, atol=1e-12)


@pytest.mark.parametrize('kind', VALUES)
def test_jacobians_of_joints_of_several_values_are_differences(tmp_path, kind):
    robot = base(tmp_path, kind, '1 2 -3')
    q, step = np.array([*VALUES[kind], 0.9]), 1e-6
    J = robot.link_jacobians(q)
    assert J.shape == (3, 6, len(q))
    for k in range(len(q)):
        ahead, behind = robot.link_transforms(q + step * np.eye(len(q))[[k]] * [[1], [-1]])
        v = (ahead[:, :3, 3] - behind[:, :3, 3]) / (2 * step)
        np.testing.assert_allclose(J[:, 3:, k], v, rtol=0, atol=1e-8)


def test_links_below_a_joint_without_values_stand_nowhere(tmp_path):
    robot = base(tmp_path, 'planar')
    assert robot.placed_links([]) == robot.placed_links(['base/x', 'turn']) == [0]
    assert robot.placed_links(['base/x', 'base/y', 'base/theta']) == [0, 1, 2]
