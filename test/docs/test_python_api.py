"""The pages of the Python API are what the docstrings say, and have every public name."""

import importlib
import inspect
import re
import runpy

import pytest
from conventions.source_tree import ROOT

GENERATOR = runpy.run_path(str(ROOT / 'docs/generate_python_api.py'))


def test_the_pages_are_current():
    pages = GENERATOR['pages']()
    written = {
        path.relative_to(ROOT / 'docs').as_posix() for path in (ROOT / 'docs/api').glob('*')
    }
    assert written == pages.keys() - {'python_api.md'}
    stale = [path for path, text in pages.items() if (ROOT / 'docs' / path).read_text() != text]
    assert stale == [], 'run: python docs/generate_python_api.py'


def test_headings_are_names():
    for path, text in GENERATOR['pages']().items():
        headings = re.findall(r'^## (.*)', text, re.M)
        assert all(re.fullmatch(r'\w+', heading) for heading in headings), path


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
    page = (ROOT / f'docs/api/{name}.md').read_text()
    assert set(getattr(module, '__all__', public)) == set(public)
    for title, thing in public.items():
        assert f'\n## {title}\n' in page
        if inspect.isclass(thing):
            for method, value in GENERATOR['members'](thing).items():
                assert f'- `{method}' in page
                assert inspect.getdoc(value), f'{title}.{method} has no docstring'
