"""Robots of many makers at random configurations: our links stand where other libraries put them.

The URDFs are those of PyPI's ``example-robot-data``; Pinocchio, where it is installed, is the
second opinion, by a model of its own.
"""

import math
from pathlib import Path

import numpy as np
import pytest
from live.inputs.test_joint_input import GAP, pose, state, waiting
from live.live_scenes import Clock, live_scene
from lxml import etree
from oracles import panda

from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import WORLD
from drake_geom_ros.scene_files.urdf_tree import read_link_tree
from drake_geom_ros.trajectories import Kinematics

ROBOTS = Path(panda.URDF).parents[2]
# No robots: a URDF without links, and one in which a joint mimics one that is not there.
REFUSED = {'ur3.urdf', 'alex_psyonic_hands.urdf'}
URDFS = sorted(path for path in ROBOTS.glob('**/*.urdf') if path.name not in REFUSED)
X_WB = RigidTransform(RollPitchYaw(0.3, -0.2, 1.0), [1.0, -2.0, 0.5])
CONFIGURATIONS = 5


def bare(path):
    """Return a URDF without shapes, which only take time to read here."""
    tree = etree.parse(path)
    for element in [*tree.iter('visual', 'collision', 'gazebo', 'transmission', 'material')]:
        element.getparent().remove(element)
    return etree.tostring(tree)


def configuration(kinematics, rng):
    """Return random values (joints,) within limits."""
    return rng.uniform(kinematics.lower.clip(-3.0), kinematics.upper.clip(max=3.0))


@pytest.fixture(scope='module')
def bare_robot(tmp_path_factory):
    folder = tmp_path_factory.mktemp('robots')

    def make(path):
        (folder / 'robot.urdf').write_bytes(bare(path))
        return folder / 'robot.urdf'

    return make


def test_there_are_dozens_of_robots():
    assert len(URDFS) >= 60


@pytest.mark.parametrize('path', URDFS, ids=lambda path: path.stem)
def test_joint_states_put_all_links_where_others_do(path, bare_robot):
    urdf = bare_robot(path)
    kinematics = Kinematics(str(urdf))
    pose_key = '{position: [1, -2, 0.5], rpy: [0.3, -0.2, 1]}'
    live = live_scene(f'robots: [{{name: it, urdf: {urdf}, pose: {pose_key}}}]\n', Clock(1000.0))
    joints = JointInput(live.clocks, GAP, by_default=True)
    rng = np.random.default_rng(len(kinematics.joint_names))
    with live.editing() as scene:
        for number in range(CONFIGURATIONS):
            q = configuration(kinematics, rng)
            order = rng.permutation(len(q))
            names = [kinematics.joint_names[k] for k in order]
            if names:
                joints.take(scene, state(names, q[order], 1000.0 + number), 0.0)
            assert not waiting(scene)
            X_WLs = kinematics.link_transforms(q, X_WB.GetAsMatrix4())
            others = by_pinocchio(urdf, kinematics, q)
            for link, X_WL in zip(kinematics.link_names, X_WLs, strict=True):
                if link == WORLD:
                    continue
                found = pose(scene, f'it::{link}')
                np.testing.assert_allclose(found, X_WL, rtol=0, atol=1e-12)
                if others is not None:
                    expected = X_WB.GetAsMatrix4() @ others[link]
                    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


def by_pinocchio(urdf, kinematics, q):
    """Return X_BL (4, 4) of all links as Pinocchio has them; None where it is not installed."""
    try:
        import pinocchio
    except ImportError:
        return None
    model = pinocchio.buildModelFromUrdf(str(urdf))
    data = model.createData()
    values = dict(zip(kinematics.joint_names, q.tolist(), strict=True))
    configured = pinocchio.neutral(model)
    for name in list(model.names)[1:]:
        joint = model.joints[model.getJointId(name)]
        value = values[name] if name in values else mimicked(read_link_tree(urdf), name, values)
        if joint.nq == 1:
            configured[joint.idx_q] = value
        elif joint.nq == 2:  # a joint without limits, by its cosine and sine
            configured[joint.idx_q : joint.idx_q + 2] = math.cos(value), math.sin(value)
        else:
            raise AssertionError(f'{name} has {joint.nq} numbers')
    pinocchio.framesForwardKinematics(model, data, configured)
    root = data.oMf[model.getFrameId(kinematics.link_names[0], pinocchio.BODY)].homogeneous
    return {
        link: np.linalg.inv(root) @ data.oMf[model.getFrameId(link, pinocchio.BODY)].homogeneous
        for link in kinematics.link_names
    }


def mimicked(tree, name, values):
    """Return the value of a joint that follows another one, maybe by way of a third."""
    mimic = next(joint.mimic for joint in tree.joints if joint.name == name)
    leader = values.get(mimic.joint)
    if leader is None:
        leader = mimicked(tree, mimic.joint, values)
    return mimic.multiplier * leader + mimic.offset
