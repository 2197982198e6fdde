"""Answers on the real middleware, in one process: sent without rclpy, or by it, and counted."""

import contextlib

import pytest
from drake_geom_msgs import srv
from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile

from drake_geom_ros.ros.outputs import service_answers
from drake_geom_ros.ros.outputs.service_answers import Answers, CallCounts, Calls, RequestId
from drake_geom_ros.ros.outputs.unlocked import CMessage
from drake_geom_ros.ros.spinning import GroupExecutor

pytestmark = pytest.mark.topics


@pytest.fixture
def served(lone_client):
    """Return the client, whose executor is ours, as that of a node is."""
    node = lone_client.node
    lone_client.serve_by(GroupExecutor(node, node.default_callback_group))
    return lone_client


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


def test_an_answer_is_sent_and_counted(served, service):
    found = Answers()
    found.send_for(service)
    assert ask(served, 'words') == 'words'
    assert ask(served, 'words' * 100_000) == 'words' * 100_000
    assert found.counts() == CallCounts(answered=2, unanswered=0, before_first=0)


def test_a_request_is_taken_with_whose_it_is(served, service):
    """Nothing of rclpy's is looked into: the number is what rcl gave, and rclpy takes nothing."""
    found, seen = Answers(), []
    found.send_for(service)
    send = service.send_response
    service.send_response = type('Spy', (Calls,), {'__call__': lambda s, *a: seen.append(a[1])})(
        service, lambda *_, **__: None
    )
    (client,) = [served.node.create_client(srv.ExplainFilter, service.srv_name)]
    client.call_async(srv.ExplainFilter.Request())
    served.wait_for(lambda: seen, 'a request')
    assert [type(each) for each in seen] == [RequestId]
    assert seen[0].sequence_number == 1
    assert any(seen[0].writer_guid)
    assert send is not service.send_response


@pytest.mark.parametrize('executor', ['ours', 'of rclpy'])
def test_where_rcl_is_not_called_rclpy_sends(lone_client, service, monkeypatch, request, executor):
    if executor == 'ours':
        monkeypatch.setattr(service_answers, 'of_rcl', lambda _: None)
        request.getfixturevalue('served')
    found = Answers()
    found.send_for(service)
    assert ask(lone_client, 'words') == 'words'
    assert found.counts() == CallCounts(answered=1, unanswered=0, before_first=0)


def test_a_service_that_was_closed_is_asked_nothing(served, service):
    found = Answers()
    found.send_for(service)
    client = served.node.create_client(srv.ExplainFilter, service.srv_name)
    served.wait_for(client.service_is_ready, 'the service')
    client.call_async(srv.ExplainFilter.Request())
    served.node.destroy_service(service)
    with pytest.raises(InvalidHandle):
        service.send_response.take()
    served.wait_for(lambda: not client.service_is_ready(), 'the end of the service')
    assert found.counts() == CallCounts(answered=0, unanswered=0, before_first=0)


def test_where_there_is_no_request_none_is_taken(served, service):
    found = Answers()
    found.send_for(service)
    assert service.send_response.take() is None


def test_numbers_that_are_missing_are_counted(served, service):
    found = Answers()
    found.send_for(service)
    assert ask(served, 'first') == 'first'
    (client,) = served.node.clients
    futures = [client.call_async(srv.ExplainFilter.Request()) for _ in range(10)]
    with contextlib.suppress(AssertionError):
        served.wait_for(lambda: all(f.done() for f in futures), 'ten answers', 1.0)
    assert ask(served, 'last') == 'last'
    answered = sum(f.done() for f in futures)  # in order: none comes after the last one
    assert answered < len(futures)
    lost = len(futures) - answered
    assert found.counts() == CallCounts(answered=2 + answered, unanswered=lost, before_first=0)
    # Another server of the same client cannot know what became of the calls before.
    again = Answers()
    again.send_for(service)
    assert ask(served, 'more') == 'more'
    assert again.counts() == CallCounts(answered=1, unanswered=0, before_first=12)


def test_an_answer_that_cannot_be_a_message_is_raised(lone_client, service):
    with pytest.raises((AssertionError, TypeError)):
        CMessage(srv.ExplainFilter.Response(message=3))
