"""Joint states of robots with planar and floating joints, which have several values each."""

import numpy as np
import pytest
from live.inputs.test_joint_input import BALL, opened, state, waiting
from live.live_scenes import Clock

from drake_geom_ros.live.services.joint_views import GivenJoints
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.kinematics import Kinematics

LINKS = ('base', 'cart', 'lift', 'drone', 'hook')
ROBOT = '<robot name="cart">' + ''.join(f'<link name="{link}">{BALL}</link>' for link in LINKS)
ROBOT += """
<joint name="slide" type="planar"><parent link="base"/><child link="cart"/>
  <origin xyz="0 0 1"/><axis xyz="0 1 0"/></joint>
<joint name="up" type="prismatic"><parent link="cart"/><child link="lift"/>
  <axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>
<joint name="fly" type="floating"><parent link="base"/><child link="drone"/></joint>
<joint name="swing" type="continuous"><parent link="drone"/><child link="hook"/>
  <origin xyz="0 0 -0.5"/><axis xyz="1 0 0"/></joint>
</robot>"""
VALUES = {
    'slide/x': 0.5,
    'slide/y': -0.25,
    'slide/theta': 0.3,
    'up': 0.4,
    'fly/x': 1.0,
    'fly/y': 2.0,
    'fly/z': 3.0,
    'fly/yaw': 0.1,
    'fly/pitch': 0.2,
    'fly/roll': 0.3,
    'swing': -0.7,
}
CART = ('slide/x', 'slide/y', 'slide/theta', 'up')


@pytest.fixture
def text(tmp_path):
    (tmp_path / 'cart.urdf').write_text(ROBOT)
    return f'robots: [{{name: cart, urdf: {tmp_path}/cart.urdf, pose: {{position: [0, 0, 0]}}}}]\n'


def assert_stands(query, names, links, values=VALUES):
    kinematics = Kinematics(read_scene(ROBOT, 'urdf').robots[0].tree)
    q = [values.get(name, 0.0) for name in kinematics.joint_names]
    X_WLs = dict(zip(kinematics.link_names, kinematics.link_transforms(q), strict=True))
    for link in links:
        X_WL = query.X_WF(names.frame(f'cart::{link}')).GetAsMatrix4()
        np.testing.assert_allclose(X_WL, X_WLs[link], rtol=0, atol=1e-14)


def test_links_stand_where_the_values_of_planar_and_floating_joints_put_them(text):
    live, joints = opened(text, Clock(1000.0))
    with live.editing() as scene:
        message = state(VALUES, VALUES.values(), 1000.0)
        assert joints.take(scene, message, 0.0) == len(LINKS) - 1
        assert not waiting(scene)
        assert_stands(scene.query, scene.model.names, LINKS)


@pytest.mark.parametrize('first', [CART, ('up',), ('swing', 'fly/z')])
def test_links_wait_only_for_the_values_that_move_them(text, first):
    live, joints = opened(text, Clock(1000.0))
    with live.editing() as scene:
        joints.take(scene, state(first, [VALUES[name] for name in first], 1000.0), 0.0)
        stand = {'base', 'cart', 'lift'} if first == CART else {'base'}
        assert waiting(scene) == set(LINKS) - stand
        assert_stands(scene.query, scene.model.names, stand)
        others = [name for name in VALUES if name not in first]
        joints.take(scene, state(others, [VALUES[name] for name in others], 1000.0), 0.0)
        assert_stands(scene.query, scene.model.names, LINKS)


def test_a_question_may_give_their_values(text):
    live, joints = opened(text, Clock(1000.0))
    with live.editing() as scene:
        joints.take(scene, state(VALUES, VALUES.values(), 1000.0), 0.0)
    given = {'slide/x': -1.0, 'fly/yaw': 1.0}
    view = live.view(None, GivenJoints(tuple(given), tuple(given.values())))
    assert_stands(view.query, view.names, LINKS, {**VALUES, **given})
