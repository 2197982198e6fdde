"""Answers on the real middleware, in one process: sent without rclpy, or by it, and counted."""

import contextlib

import pytest
from drake_geom_msgs import srv
from rclpy.qos import QoSProfile

from drake_geom_ros.ros.outputs import answers
from drake_geom_ros.ros.outputs.answers import Answers, CallCounts
from drake_geom_ros.ros.outputs.unlocked import CMessage


@pytest.fixture
def service(lone_client):
    """Return a service of the client's own node, which says what it was asked."""

    def answer(request, response):
        response.success, response.message = True, request.geometry_a
        return response

    name = f'{lone_client.server}/explain_filter'
    profile = QoSProfile(depth=3)
    return lone_client.node.create_service(srv.ExplainFilter, name, answer, qos_profile=profile)


def ask(client, text):
    return client.call(srv.ExplainFilter, 'explain_filter', geometry_a=text).message


def test_an_answer_is_sent_and_counted(lone_client, service):
    found = Answers()
    found.send_for(service)
    assert ask(lone_client, 'words') == 'words'
    assert ask(lone_client, 'words' * 100_000) == 'words' * 100_000
    assert found.counts() == CallCounts(answered=2, unanswered=0, before_first=0)


@pytest.mark.parametrize('missing', ['of_rcl', '_request_id'])
def test_where_rcl_cannot_be_called_rclpy_sends(lone_client, service, monkeypatch, missing):
    monkeypatch.setattr(answers, missing, lambda *anything: None)
    found = Answers()
    found.send_for(service)
    assert ask(lone_client, 'words') == 'words'
    assert found.counts().answered == 1


def test_numbers_that_are_missing_are_counted(lone_client, service):
    found = Answers()
    found.send_for(service)
    assert ask(lone_client, 'first') == 'first'
    (client,) = lone_client.node.clients
    futures = [client.call_async(srv.ExplainFilter.Request()) for _ in range(10)]
    with contextlib.suppress(AssertionError):
        lone_client.wait_for(lambda: all(f.done() for f in futures), 'ten answers', 1.0)
    answered = sum(f.done() for f in futures)
    assert answered < len(futures)
    assert ask(lone_client, 'last') == 'last'
    lost = len(futures) - answered
    assert found.counts() == CallCounts(answered=2 + answered, unanswered=lost, before_first=0)
    # Another server of the same client cannot know what became of the calls before.
    again = Answers()
    again.send_for(service)
    assert ask(lone_client, 'more') == 'more'
    assert again.counts() == CallCounts(answered=1, unanswered=0, before_first=12)


def test_an_answer_that_cannot_be_a_message_is_raised(lone_client, service):
    with pytest.raises((AssertionError, TypeError)):
        CMessage(srv.ExplainFilter.Response(message=3))
