"""Where sensors were at the stamps of what they saw, whoever tells of which part, and when."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.inputs.sensing_node import SCENE, Node, header
from live.inputs.tf_messages import at, message, transform

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene import moments
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes.attachment import attachment, detachment
from drake_geom_ros.live.scene.moments import moment_of
from drake_geom_ros.math import RigidTransform

LIMIT = '<limit lower="-50" upper="50" effort="1" velocity="1"/>'
ROBOT = f"""<robot name="r"><link name="base"/><link name="one"/><link name="two"/>
<joint name="j" type="prismatic"><parent link="base"/><child link="one"/>{LIMIT}</joint>
<joint name="k" type="prismatic"><parent link="one"/><child link="two"/>
<axis xyz="0 1 0"/>{LIMIT}</joint></robot>"""
TURNING = """<robot name="r"><link name="base"/><link name="one"/>
<joint name="j" type="continuous"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>
</joint></robot>"""
SPEEDS = {'base': 1.0, 'j': 3.0, 'k': -2.0}  # [m/s] along x, x and y


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(moments, 'PATIENCE', 0.02)


@pytest.fixture(scope='module')
def scenes(tmp_path_factory):
    """Return a function that writes a scene of a robot, with more of a scene file."""
    folder = tmp_path_factory.mktemp('robots')

    def written(urdf=ROBOT, more='', keys=''):
        (folder / 'r.urdf').write_text(urdf)
        frames = 'sources: [s]\nframes: [{name: mast, source: s, pose: {}, static: true}, '
        told = f'{frames}{more}]\nrobots: [{{name: r, urdf: r.urdf{keys}}}]'
        (folder / 's.yaml').write_text(told)
        return str(folder / 's.yaml')

    return written


class Robot(Node):
    """A node whose robot is told of by parts."""

    def __init__(self, scene, tf=None):
        super().__init__(scene=scene, tf=tf, self_filter='none')
        joints = JointInput(self.live.clocks, 1.0, by_default=True)
        self.inputs = PoseInputs(self.tf, joints)

    def pose(self, stamp, frame, x, y=0.0):
        self.clock.now = max(self.clock.now, stamp)
        told = Plain(
            header=header('world', stamp), source='', frame_names=[frame], frame_ids=[],
            poses=[x, y, 0.0, 0.0, 0.0, 0.0, 1.0],
        )  # fmt: skip
        with self.live.editing() as scene:
            self.inputs.take_poses(scene, told)

    def joint(self, stamp, **positions):
        self.clock.now = max(self.clock.now, stamp)
        told = Plain(
            header=header('', stamp), name=list(positions), position=list(positions.values()),
            velocity=[],
        )  # fmt: skip
        with self.live.editing() as scene:
            self.inputs.take_joint_states(scene, told)

    def transform(self, stamp, parent, child, x):
        self.clock.now = max(self.clock.now, stamp)
        with self.live.editing() as scene:
            self.tf.hear(message(transform(parent, child, at(x), stamp)), static=False)
            self.inputs.pose_by_transforms(scene)

    def tell_part(self, part, stamp):
        """Tell of a part that moves at a constant speed."""
        way = SPEEDS[part] * (stamp - 100.0)
        if part == 'base':
            self.pose(stamp, 'r::base', way)
        else:
            self.joint(stamp, **{part: way})

    def then(self, frame, stamp):
        """Return where a frame was at a stamp."""
        self.clock.now = max(self.clock.now, stamp)
        found = moment_of(self.live, header(frame, stamp), 0.0, self.input._hanging, lambda *_: ())
        return found.X_WF


@settings(max_examples=25, deadline=None)
@given(st.data())
def test_each_part_is_where_it_was_at_that_very_time(scenes, data):
    """Base and joints are told of at rates of their own, and move straight between."""
    node = Robot(scenes())
    steps = {part: data.draw(st.sampled_from([0.01, 0.03, 0.1, 0.17])) for part in SPEEDS}
    told = sorted(
        (100.0 + k * step, part)
        for part, step in steps.items()
        for k in range(round(1.0 / step) + 2)
    )
    for stamp, part in told:
        node.tell_part(part, stamp)
    stamp = 100.0 + data.draw(st.floats(0.3, 0.9))
    t = round(stamp % 1 * 1e9) * 1e-9  # as a stamp says it
    for frame, expected in (
        ('r::base', [t, 0.0]),
        ('r::one', [4.0 * t, 0.0]),
        ('r::two', [4.0 * t, -2.0 * t]),
    ):
        assert node.then(frame, stamp).translation()[:2] == pytest.approx(expected, abs=1e-6)


def test_links_of_two_robots_of_one_message_are_where_each_was(scenes):
    two = ', pose: {}}, {name: q, urdf: r.urdf, pose: {position: [0, 5, 0]}'
    node = Robot(scenes(keys=two))
    for stamp, way in ((100.0, 0.0), (100.2, 1.0)):
        node.joint(stamp, **{'r::j': way, 'q::j': -2.0 * way, 'r::k': 0.0, 'q::k': way})
    for frame, expected in (
        ('r::two', [0.5, 0.0]),
        ('q::one', [-1.0, 5.0]),
        ('q::two', [-1.0, 5.5]),
    ):
        assert node.then(frame, 100.1).translation()[:2] == pytest.approx(expected, abs=1e-6)


def test_a_part_of_which_nothing_came_since_is_waited_for_and_not_taken_for_that_of_then(scenes):
    node = Robot(scenes())
    for k in range(5):
        node.tell_part('base', 100.0 + 0.1 * k)
    for part in 'jk':
        node.tell_part(part, 100.0)
        node.tell_part(part, 100.1)
    assert node.then('r::base', 100.35).translation()[0] == pytest.approx(0.35, abs=1e-6)
    with pytest.raises(RuntimeError, match=r'r::one.* not known: no pose of then or later'):
        node.then('r::one', 100.35)
    node.tell_part('j', 100.4)
    assert node.then('r::one', 100.35).translation()[0] == pytest.approx(4 * 0.35, abs=1e-6)
    with pytest.raises(RuntimeError, match='r::two'):
        node.then('r::two', 100.35)
    node.tell_part('k', 100.7)  # across a gap of 0.6 s nobody knows
    with pytest.raises(RuntimeError, match=r'r::two.*gap'):
        node.then('r::two', 100.35)


def test_a_joint_that_goes_round_turns_by_the_shorter_way(scenes):
    node = Robot(scenes(TURNING, keys=', pose: {}'))
    node.joint(100.0, j=3.1)
    node.joint(100.1, j=-3.1)
    X_WF = node.then('r::one', 100.05)
    assert X_WF.rotation().matrix()[:2, 0] == pytest.approx([-1.0, 0.0], abs=1e-6)


def test_a_change_of_the_model_makes_nothing_of_the_past_unknown(scenes):
    node = Robot(scenes())
    for stamp in (100.0, 100.2):
        for part in SPEEDS:
            node.tell_part(part, stamp)
    with node.live.editing() as scene:
        scene.make(Change(lambda graph, _: graph.RegisterSource('another')))
        node.inputs.follow(scene)
    assert node.then('r::two', 100.1).translation()[:2] == pytest.approx([0.4, -0.2], abs=1e-6)


def test_each_transform_of_a_chain_is_that_of_the_same_time(scenes):
    """``base`` is told of at 50 Hz, what is on it at 10 Hz, and ``tip`` is no frame of a scene."""
    scene = scenes(more='{name: base, source: s}, {name: arm, source: s}, {name: cup, source: s}')
    node = Robot(scene, tf=TfInput)
    for k in range(51):
        stamp = 100.0 + 0.02 * k
        node.transform(stamp, 'world', 's/base', stamp - 100.0)
        if k % 5 == 0:
            node.transform(stamp, 's/base', 's/arm', 3.0 * (stamp - 100.0))
            node.transform(stamp, 's/arm', 's/cup', -1.0 * (stamp - 100.0))
    for t in (0.35, 0.5, 0.59, 0.83):
        for frame, speed in (('s::base', 1.0), ('s::arm', 4.0), ('s::cup', 3.0)):
            x = node.then(frame, 100.0 + t).translation()[0]
            assert x == pytest.approx(speed * t, abs=1e-6), (t, frame)


def test_a_chain_that_ends_at_a_robot_moves_with_it(scenes):
    """The base comes by ~/frame_poses, the arm on it by TF, and both move."""
    node = Robot(scenes(more='{name: arm, source: s}', keys=', pose: {}'), tf=TfInput)
    for k in range(51):
        stamp = 100.0 + 0.02 * k
        node.pose(stamp, 'r::base', stamp - 100.0)
        if k % 5 == 0:
            node.transform(stamp, 'r/base', 's/arm', 3.0 * (stamp - 100.0))
    for t in (0.35, 0.5, 0.59):
        assert node.then('s::arm', 100.0 + t).translation()[0] == pytest.approx(4 * t, abs=1e-6)


def test_a_transform_of_another_parent_is_not_that_of_then(scenes):
    node = Robot(scenes(more='{name: arm, source: s}'), tf=TfInput)
    for k, parent in enumerate(('world', 'world', 'mast', 'mast')):
        node.transform(100.0 + 0.1 * k, parent, 's/arm', float(k))
    with pytest.raises(RuntimeError, match='s::arm'):
        node.then('s::arm', 100.15)
    assert node.then('s::arm', 100.25).translation()[0] == pytest.approx(2.5, abs=1e-6)


def test_what_was_attached_was_where_it_was_before():
    node = Node(scene=SCENE, self_filter='none')

    def then(stamp):
        found = moment_of(node.live, header('arm', stamp), 0.0, node.input._hanging, lambda *_: ())
        return found.X_WF.translation().tolist()

    node.clock.now = 100.1
    node.move(100.0, [1, 0, 0])
    node.move(100.1, [1, 0, 0])
    with node.live.editing() as scene:
        arm, mast = (scene.model.names.frame(name) for name in ('arm', 'mast'))
        scene.make(attachment(scene, arm, mast, RigidTransform([0, 0, 0.5])))
    with pytest.raises(RuntimeError, match='hung on another'):
        then(100.05)
    node.clock.now = 100.2
    assert then(100.2) == [0.0, 0.0, 2.5]
    # What somebody sends of an attached frame is left out, then and now.
    node.move(100.15, [7, 0, 0])
    node.move(100.25, [7, 0, 0])
    assert then(100.2) == [0.0, 0.0, 2.5]
    node.clock.now = 100.3
    with node.live.editing() as scene:
        scene.make(detachment(scene, arm, None))
    for stamp in (100.2, 100.3):
        with pytest.raises(RuntimeError, match='s::arm'):
            then(stamp)
    node.clock.now = 100.5
    node.move(100.4, [0, 0, 3])
    node.move(100.5, [0, 0, 4])
    assert then(100.45) == pytest.approx([0.0, 0.0, 3.5])
    with pytest.raises(RuntimeError, match='s::arm'):
        then(100.2)


def test_a_robot_on_its_own_link_is_refused_and_no_endless_question(scenes):
    node = Robot(scenes(keys=', pose: {}'))
    for stamp in (100.0, 100.1):
        node.joint(stamp, j=0.0, k=0.0)
        node.pose(stamp, 'r::base', 0.0)
    with node.live.reading() as scene:
        base, one = (scene.model.names.frame(f'r::{name}') for name in ('base', 'one'))
        then = moments._Then(scene, scene.poses.history.around(100.05))
    then._around.row = lambda frame, then: then.X_PF(
        one if FrameId(frame) == base else base
    ).ToArray()
    with pytest.raises(moments.UnknownThenError):
        then.X_PF(one)
    assert np.allclose(node.then('r::one', 100.05).translation(), 0.0)
