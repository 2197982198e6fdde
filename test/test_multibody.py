"""Parts of pydrake that are not rebuilt name the page about porting."""

import importlib

import pytest


@pytest.mark.parametrize('name', ['multibody', 'multibody.plant', 'systems', 'systems.framework'])
def test_an_import_of_what_is_not_rebuilt_says_how_to_port(name):
    with pytest.raises(ImportError, match=r'docs/differences_from_pydrake\.md'):
        importlib.import_module(f'drake_geom_ros.{name}')
