"""Messages handed to rcl without the interpreter's lock, on the real middleware."""

import array

import pytest
from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Image

from drake_geom_ros.ros.outputs import unlocked

pytestmark = pytest.mark.topics


@pytest.fixture
def publisher(lone_client):
    topic = f'{lone_client.server}/image'
    return lone_client.node.create_publisher(Image, topic, QoSProfile(depth=2))


def image(value):
    """Return an image whose bytes are all of one value."""
    pixels = array.array('B', bytes([value]) * 30_000)
    return Image(height=100, width=100, encoding='rgb8', step=300, data=pixels)


@pytest.mark.parametrize('has_rcl', [True, False])
def test_a_message_arrives_as_it_is(lone_client, publisher, monkeypatch, has_rcl):
    if not has_rcl:
        monkeypatch.setattr(unlocked, 'of_rcl', lambda name: None)
    came = []
    lone_client.node.create_subscription(Image, publisher.topic_name, came.append, 2)
    sent = image(3)
    sent.header.stamp.sec, sent.header.frame_id = 5, 'hand'

    def has_come():
        unlocked.publish(publisher, sent)
        return bool(came)

    lone_client.wait_for(has_come, 'an image')
    assert came[0] == sent


def test_what_is_no_message_is_raised(publisher):
    with pytest.raises((AssertionError, TypeError)):
        unlocked.publish(publisher, Image(encoding=3))


def test_a_topic_that_was_closed_is_told(lone_client, publisher):
    lone_client.node.destroy_publisher(publisher)
    with pytest.raises(InvalidHandle):
        unlocked.publish(publisher, image(1))


def test_what_rcl_refuses_is_raised(publisher, monkeypatch):
    monkeypatch.setattr(unlocked, 'of_rcl', lambda name: lambda *addresses: 1)
    with pytest.raises(RuntimeError, match=r'/image was not sent: rcl returned 1'):
        unlocked.publish(publisher, image(1))


def test_a_publisher_of_large_messages_is_one(lone_client, publisher):
    large, came = unlocked.LargePublisher(publisher), []
    assert large.get_subscription_count() == publisher.get_subscription_count() == 0
    lone_client.node.create_subscription(Image, publisher.topic_name, came.append, 2)
    lone_client.wait_for(lambda: large.get_subscription_count() == 1, 'a listener')
    large.publish(image(7))
    lone_client.wait_for(lambda: came, 'an image')
    assert came[0] == image(7)
