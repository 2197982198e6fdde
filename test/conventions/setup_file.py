"""The description of the package in setup.py."""

import runpy
from unittest import mock

from conventions.source_tree import ROOT


def setup_keywords():
    """Return the keyword arguments that setup.py passes to setuptools.setup()."""
    with mock.patch('setuptools.setup') as setup:
        runpy.run_path(str(ROOT / 'setup.py'))
    return setup.call_args.kwargs
