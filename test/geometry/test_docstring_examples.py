"""The examples in the docstrings run, with the public names at hand, and print what they say."""

import doctest
import importlib
import pkgutil

import pytest

import drake_geom_ros.common
import drake_geom_ros.geometry
import drake_geom_ros.math

PACKAGES = (drake_geom_ros.math, drake_geom_ros.common, drake_geom_ros.geometry)
NAMES = {name: getattr(package, name) for package in PACKAGES for name in package.__all__}
MODULES = [
    f'{package.__name__}.{module.name}'
    for package in PACKAGES
    for module in pkgutil.iter_modules(package.__path__)
    if not module.ispkg
]
FINDER = doctest.DocTestFinder(exclude_empty=True)


def examples_of(module):
    """Return the examples of a module that has been imported."""
    found = FINDER.find(importlib.import_module(module), extraglobs=NAMES)
    return [example for example in found if example.examples]


@pytest.mark.parametrize('module', MODULES)
def test_examples(module):
    for example in examples_of(module):
        said = []
        result = doctest.DocTestRunner().run(example, out=said.append)
        assert result.failed == 0, ''.join(said)


def test_there_are_examples_to_run():
    assert sum(len(examples_of(module)) for module in MODULES) >= 8
