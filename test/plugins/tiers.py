"""The two tiers: ``pytest`` judges behaviour, ``pytest --everything`` also what takes long.

``everything`` marks what only the second one runs: packaging, the browser, short soaks, all laws
of the catalogue, second opinions by processes. ``packaging`` implies it.
"""

from __future__ import annotations

EVERYTHING = '--everything'


def pytest_addoption(parser):
    parser.addoption(
        EVERYTHING, action='store_true', help='also packaging, the browser, soaks and all laws'
    )


def pytest_collection_modifyitems(config, items):
    if config.getoption(EVERYTHING):
        return
    later = [item for item in items if is_later(item)]
    if later:
        config.hook.pytest_deselected(items=later)
        items[:] = [item for item in items if not is_later(item)]


def is_later(item):
    """Return whether only ``--everything`` runs a test."""
    return any(item.get_closest_marker(mark) for mark in ('everything', 'packaging'))
