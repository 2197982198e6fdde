"""docs/python_api.md is what the docstrings say, and has every public name."""

import importlib
import inspect
import runpy

import pytest
from conventions.source_tree import ROOT

GENERATOR = runpy.run_path(str(ROOT / 'docs/generate_python_api.py'))
PAGE = (ROOT / 'docs/python_api.md').read_text()


def test_the_page_is_current():
    assert GENERATOR['api']() == PAGE, 'run: python docs/generate_python_api.py'


def test_sections_of_a_docstring_become_lists():
    def call():
        """Return a call.

        Args:
            name: The name, which
                may be long.
            rate: [Hz]

        Returns:
            The call.
        """

    assert GENERATOR['_text'](call) == (
        'Return a call.\n\nArgs:\n\n- `name`: The name, which\n  may be long.\n- `rate`: [Hz]\n\n'
        'Returns:\n\nThe call.'
    )


@pytest.mark.parametrize('name', GENERATOR['MODULES'])
def test_every_name_has_a_section_and_every_method_a_line(name):
    module = importlib.import_module(f'drake_geom_ros.{name}')
    public = GENERATOR['public'](module)
    assert set(getattr(module, '__all__', public)) == set(public)
    for title, thing in public.items():
        assert f'\n### {title}' in PAGE
        if inspect.isclass(thing):
            for method, value in GENERATOR['members'](thing).items():
                assert f'- `{method}' in PAGE
                assert inspect.getdoc(value), f'{title}.{method} has no docstring'
