"""docs/inputs.md against a real node: its script, its message, its tables."""

import re

import pytest
import yaml
from drake_geom_msgs import msg, srv
from ros.harness import ROOT, run_python, start_node, wait_until_ready
from ros.scene_calls import accepted
from ros.test_readme import filled

from drake_geom_ros.ros.parameters import NodeParameters

TEXT = (ROOT / 'docs/inputs.md').read_text()


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    log = tmp_path_factory.mktemp('inputs') / 'log'
    asked = {'point_threshold': 1.0, 'closing_speeds': True, 'use_joint_states': True}
    process = start_node(log, scene_file='scenes/minimal.yaml', **asked)
    yield process
    assert process.end() == 0, process.output()


@pytest.mark.topics
def test_the_script_prints_what_is_shown(node, client):
    """First: the ball still stands where the scene file puts it."""
    wait_until_ready(client)
    done = run_python('examples/feed_the_node.py')
    assert done.returncode == 0, done.stderr + node.output()
    assert f'```\n{done.stdout}```' in TEXT


@pytest.mark.topics
def test_the_message_poses_the_ball(client):
    request = re.search(r"frame_poses \S+ '(\{.*\})'$", TEXT, re.M).group(1)
    message = filled(msg.FramePoses(), yaml.safe_load(request))
    publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def posed():
        publisher.publish(message)
        position = accepted(client.call(srv.GetPose, 'get_pose', frame='ball')).pose.pose.position
        return [position.x, position.y, position.z] == list(message.poses[:3])

    client.wait_for(posed, 'the pose')


@pytest.mark.topics
def test_the_message_brings_a_person(client):
    request = re.search(r"tracked_objects \S+ '(\{.*\})'$", TEXT, re.M).group(1)
    message = filled(msg.TrackedObjects(), yaml.safe_load(request))
    publisher = client.publisher(msg.TrackedObjects, 'tracked_objects')

    def there():
        publisher.publish(message)
        return client.call(srv.GetPose, 'get_pose', frame='tracked::anna').success

    client.wait_for(there, 'anna')


@pytest.mark.topics
def test_inputs_have_the_quality_of_service_that_the_table_says(client):
    rows = re.findall(
        r'^\| `([\w~/]+)` \| `\S+` \| (best effort|reliable), (latched, )?', TEXT, re.M
    )
    assert len(rows) == 7
    for topic, reliability, latched in rows:
        name = topic.replace('~', '/scene_graph') if topic.startswith('~') else f'/{topic}'
        client.wait_for(lambda n=name: client.node.get_subscriptions_info_by_topic(n), name)
        (found,) = client.node.get_subscriptions_info_by_topic(name)
        profile = found.qos_profile
        assert profile.reliability.name == reliability.upper().replace(' ', '_')
        assert profile.durability.name == ('TRANSIENT_LOCAL' if latched else 'VOLATILE')


def test_the_parameters_have_the_defaults_that_the_table_says():
    rows = dict(re.findall(r'^\| `(\w+)` \| ([^|]+) \| [^|]+ \|$', TEXT, re.M))
    defaults = NodeParameters()
    for name in ('rate', 'world_frame', 'use_tf', 'robot_description_topic', 'stale_after',
                 'point_threshold'):  # fmt: skip
        told = yaml.safe_load(rows[name].strip('`'))
        assert told == getattr(defaults, name), name
