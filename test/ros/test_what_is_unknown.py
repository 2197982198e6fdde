"""What a real node does not know must not look known: poses, frames that rest, parameters."""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from ros.harness import LATCHED, start_node
from ros.scene_calls import accepted, poses
from std_msgs.msg import String

pytestmark = pytest.mark.topics

SCENE = """
sources: [cell]
frames:
- {name: table, source: cell, pose: {position: [0, 0, -2]}}
- {name: cart, source: cell, pose: {position: [5, 0, 0]}}
geometries:
- {name: floor, source: cell, pose: {position: [0, 0, -5]}, shape: {type: half_space}}
- {name: top, source: cell, frame: table, shape: {type: box, size: [1, 1, 0.1]}}
- {name: load, source: cell, frame: cart, shape: {type: box, size: [1, 1, 1]}}
"""
SPHERE = '<collision><geometry><sphere radius="0.3"/></geometry></collision>'
ARM = (
    '<robot name="{}">'
    + ''.join(f'<link name="{name}">{SPHERE}</link>' for name in ('foot', 'arm', 'hand'))
    + '</robot>'
)


class Observer:
    """Listens to a node with SCENE."""

    def __init__(self, process, client):
        self.process, self.client = process, client
        self.results = client.listen(msg.SignedDistancePairs, 'signed_distances')
        self.reports = client.listen(msg.CycleReport, 'cycle_report')
        self._diagnostics = client.listen(DiagnosticArray, '/diagnostics')
        self._poses = client.publisher(msg.FramePoses, 'frame_poses')
        self._robots = client.node.create_publisher(String, '/robot_description', LATCHED)
        client.wait_for(self._robots.get_subscription_count, 'a listener to robots')

    def describe(self, name):
        self._robots.publish(String(data=ARM.format(name)))

    def pose_cart(self):
        self._poses.publish(poses(['cart'], [(6, 0, 0)], 'cell'))

    def next_result(self):
        """Return a result for poses sent now."""
        self.results.clear()

        def fresh():
            self.pose_cart()
            return self.results

        return self.client.wait_for(fresh, 'a result')[-1]

    def next_status(self):
        self._diagnostics.clear()
        return self.client.wait_for(lambda: self._diagnostics, 'diagnostics')[-1].status[0]

    def warned(self, words):
        self.client.wait_for(lambda: words in self.next_status().message, f'{words!r}')


@pytest.fixture
def cell(tmp_path, lone_client):
    file = tmp_path / 'scene.yaml'
    file.write_text(SCENE)
    process = start_node(tmp_path / 'log', scene_file=file, max_distance=50.0, stale_after=0.5)
    try:
        yield Observer(process, lone_client)
    finally:
        code = process.end()
    assert code == 0, process.output()
    assert 'Traceback' not in process.output()


def test_a_robot_that_was_never_posed_is_left_out_counted_and_named(cell):
    """It would stand with all links at the origin, and 0.6 m deep in itself."""
    cell.describe('lost')
    cell.client.wait_for(lambda: "robot 'lost' added" in cell.process.output(), 'the robot')
    assert min(cell.next_result().distance) > 0.0
    assert [len(m.distance) for m in cell.results] == [3] * len(cell.results)
    cell.client.wait_for(lambda: cell.reports and cell.reports[-1].waiting_pairs, 'a report')
    assert cell.reports[-1].waiting_frames == ['lost::foot', 'lost::arm', 'lost::hand']
    assert cell.reports[-1].waiting_pairs == 12  # three of its own, three with each of three
    left_out = '12 pairs are left out because 3 frames never had a pose'
    told = f'{left_out}: lost::foot, lost::arm, lost::hand'
    cell.warned(told)
    cell.next_status()
    assert cell.process.output().count(told) == 1
    whole = accepted(
        cell.client.call(srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise')
    )
    assert told in whole.message
    assert math.isinf(whole.result.oldest_pose_age)


def test_what_rests_where_the_file_put_it_has_no_age_and_what_moved_has(cell):
    assert cell.next_status().message.endswith('pose messages')  # nothing to warn of
    # Of what is younger than the table a busy machine may tell only later.
    cell.client.wait_for(lambda: cell.next_result().oldest_pose_age < 0.5, 'a young result')
    cell.warned('1 of 2 frames are stale (older than 0.5 s): cell::cart')
    view = cell.client.call(srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise')
    assert 0.5 < accepted(view).result.oldest_pose_age < math.inf


def test_a_scene_that_is_saved_and_loaded_knows_what_moved(cell):
    """The cart moved, and who moved it may be gone: where it is now is not known."""
    cell.next_result()
    text = accepted(cell.client.call(srv.SaveScene, 'save_scene')).text
    accepted(cell.client.call(srv.LoadScene, 'load_scene', text=text, replace=True))
    cell.warned('1 of 2 frames are stale (older than 0.5 s): cell::cart')


def test_a_robot_called_as_a_source_of_the_scene_is_refused_with_the_remedy(cell):
    cell.describe('cell')
    words = "called 'cell', but the scene has a source of that name", "robot_description_topic:=''"
    cell.client.wait_for(
        lambda: all(each in cell.process.output() for each in words), 'the refusal in the log'
    )


def test_parameters_that_do_not_exist_are_told_with_the_nearest_name(tmp_path, lone_client):
    unknown = {
        'max_distanse': 0.5,
        'zzz': 1,
        'qos_overrides./scene_graph/frame_posses.subscription.depth': 3,
        'qos_overrides./scene_graph/frame_poses.subscription.depth': 3,
    }
    process = start_node(tmp_path / 'log', **unknown)
    try:
        accepted(lone_client.call(srv.HasCollisions, 'has_collisions'))
        assert "parameter 'max_distanse' does not exist; nearest: 'max_distance'" in (
            process.output()
        )
        assert "parameter 'zzz' does not exist" in process.output()
        told = (
            "parameter 'qos_overrides./scene_graph/frame_posses.subscription.depth' does not "
            "exist; nearest: 'qos_overrides./scene_graph/frame_poses.subscription.depth'"
        )
        # Topics declare theirs when the node is configured, and services answer before its end.
        lone_client.wait_for(lambda: told in process.output(), 'the override in the log')
        assert process.output().count('does not exist') == 3
    finally:
        assert process.end() == 0


def test_a_node_that_could_not_be_configured_says_how_to_go_on(tmp_path, lone_client):
    process = start_node(tmp_path / 'log', scene_file=tmp_path / 'scene.yaml')
    states = lone_client.node.create_client(GetState, '/scene_graph/get_state')
    change = lone_client.node.create_client(ChangeState, '/scene_graph/change_state')
    try:
        words = 'configured and answers no requests', '`ros2 lifecycle set /scene_graph configure`'
        lone_client.wait_for(
            lambda: all(each in process.output() for each in words), 'the advice in the log'
        )
        assert 'scene.yaml: cannot be read' in process.output()
        (tmp_path / 'scene.yaml').write_text(SCENE)
        for transition in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
            lone_client.wait_for(change.service_is_ready, 'the node')
            request = ChangeState.Request(transition=Transition(id=transition))
            future = change.call_async(request)
            lone_client.wait_for(future.done, 'the transition')
            assert future.result().success
        future = states.call_async(GetState.Request())
        lone_client.wait_for(future.done, 'the state')
        assert future.result().current_state.label == 'active'
    finally:
        assert process.end() == 0
