"""An import of what pydrake has and this package has not says where to look."""

import importlib

import pytest
from conventions.source_tree import ROOT


@pytest.mark.parametrize(
    ('module', 'name'),
    [('geometry', 'RenderEngineGlParams'), ('math', 'wrap_to'), ('common', 'temp_directory')],
)
def test_an_import_of_a_missing_name_points_to_the_page(module, name):
    with pytest.raises(ImportError, match=f'{name!r} from .drake_geom_ros.{module}') as told:
        exec(f'from drake_geom_ros.{module} import {name}')
    page = 'docs/differences_from_pydrake.md'
    assert page in str(told.value)
    assert '## Missing' in (ROOT / page).read_text()


@pytest.mark.parametrize('module', ['geometry', 'math', 'common'])
def test_asking_for_a_missing_name_is_an_attribute_error(module):
    package = importlib.import_module(f'drake_geom_ros.{module}')
    assert not hasattr(package, 'wrap_to')
    with pytest.raises(AttributeError, match='differences_from_pydrake'):
        _ = package.wrap_to


def test_a_name_that_has_another_place_here_is_pointed_to():
    with pytest.raises(ImportError, match=r"'Meshcat'.*drake_geom_ros\.viewing\.meshcat"):
        exec('from drake_geom_ros.geometry import Meshcat')


def test_modules_are_imported_as_ever():
    from drake_geom_ros.common import nearest
    from drake_geom_ros.geometry.model import rgba

    assert rgba.Rgba is not None
    assert nearest.nearest is not None
