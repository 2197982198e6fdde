"""A caller whose answer is lost calls again, and goes on with either answer."""

from types import SimpleNamespace

import pytest
from rclpy.task import Future

from bench.ros import mix

pytestmark = pytest.mark.topics


class Service:
    """Stands for the client of a service: the test answers."""

    def __init__(self):
        self.calls = []

    def call_async(self, request):
        self.calls.append((request, Future()))
        return self.calls[-1][1]

    def remove_pending_request(self, future):
        future.cancel()

    def answer(self, *, success):
        self.calls[-1][1].set_result(SimpleNamespace(success=success, message='taken'))


@pytest.fixture
def sources():
    return Service()


@pytest.fixture
def caller(sources):
    services = {'register_source': sources, 'register_frame': Service()}
    caller = mix.MixedClient(services, 'caller', 0, mix.Tally())
    caller.tick()
    return caller


def test_a_call_that_is_late_is_made_again(caller, sources, monkeypatch):
    caller.tick()
    assert len(sources.calls) == 1
    monkeypatch.setattr(mix, 'LOST', 0.0)
    caller.tick()
    (first, lost), (second, _) = sources.calls
    assert first is second
    assert lost.cancelled()
    assert not caller.is_answered()
    assert caller._tally.problems == ['caller: register_source had no answer in 0 s']
    # What the lost call registered is there.
    sources.answer(success=False)
    caller.tick()
    assert len(caller._tally.problems) == 1
    assert caller._tally.calls == {'register_source': 1}
    assert len(caller._services['register_frame'].calls) == 1


def test_a_refusal_of_a_call_that_was_made_once_is_a_problem(caller, sources):
    sources.answer(success=False)
    caller.tick()
    assert caller._tally.problems == ['caller: register_source said False: taken']
