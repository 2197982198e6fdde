"""Marks of tests that may race: the fixtures that hand out a node or a client imply ``topics``."""

from __future__ import annotations

RACY = ('processes', 'topics', 'clock')
NODE_FIXTURES = frozenset({'node', 'client', 'lone_client', 'module_client'})


def pytest_collection_modifyitems(items):
    for item in items:
        if NODE_FIXTURES & set(getattr(item, 'fixturenames', ())):
            item.add_marker('topics')
