"""``--reversed`` runs the files in reversed order: tests that rely on those before them then fail.

The tests of a file keep their order, so that fixtures of a file are made once.
"""

from __future__ import annotations

import pytest

REVERSED = '--reversed'


def pytest_addoption(parser):
    parser.addoption(REVERSED, action='store_true', help='run the last file first')


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config, items):
    if config.getoption(REVERSED):
        files = dict.fromkeys(item.path for item in items)
        places = {file: -number for number, file in enumerate(files)}
        items.sort(key=lambda item: places[item.path])
