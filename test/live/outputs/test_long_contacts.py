"""Surfaces that are computed beside the cycles: none follows what a later cycle published."""

import threading
from types import SimpleNamespace as Plain

import pytest

from drake_geom_ros.live.outputs.long_contacts import ContactRequest, LongContacts

pytestmark = pytest.mark.clock

PATIENCE = 60.0  # [s]


def request():
    query = Plain(contacts=lambda **_: 'surfaces')
    return ContactRequest(Plain(query=query), *[None] * 3, time_budget=0.0, began=0.0)


def test_after_forget_nothing_of_before_is_published():
    """A cycle without surfaces comes while older ones are about to be published."""
    order, begun = [], threading.Event()

    def cycle():
        assert begun.wait(PATIENCE)
        long.forget()
        order.append('none')

    other = threading.Thread(target=cycle)

    def publish():
        begun.set()
        other.join(0.5)  # a cycle that did not wait would be done by then
        order.append('older')

    long = LongContacts(lambda *_: publish, lambda: False, pytest.fail)
    other.start()
    long.ask(request())
    other.join(PATIENCE)
    long.close()
    assert order == ['older', 'none']


def test_what_was_forgotten_while_it_was_prepared_is_not_published():
    published = []

    def prepare(*_):
        long.forget()
        done.set()
        return lambda: published.append('older')

    done = threading.Event()
    long = LongContacts(prepare, lambda: False, pytest.fail)
    long.ask(request())
    assert done.wait(PATIENCE)
    long.close()
    assert published == []
