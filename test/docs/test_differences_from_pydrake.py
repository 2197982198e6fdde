"""docs/differences_from_pydrake.md tells what runs, and all that is missing."""

import importlib.util
import os
import runpy
import subprocess
import sys

import pytest
import yaml
from conventions.source_tree import ROOT
from ported.answers import DIFFERENCES, answer, of_pydrake
from ported.pydrake_names import ours, recorded

GENERATOR = runpy.run_path(str(ROOT / 'docs/generate_differences_from_pydrake.py'))
TABLE = yaml.safe_load(DIFFERENCES.read_text())
EXAMPLES = TABLE['on_purpose']


def test_the_page_is_current():
    page = ROOT / 'docs/differences_from_pydrake.md'
    assert page.read_text() == GENERATOR['differences'](), (
        'run: python docs/generate_differences_from_pydrake.py'
    )


@pytest.mark.parametrize('example', EXAMPLES, ids=lambda e: e['title'])
def test_what_it_says_of_ours(example):
    assert answer(example['code'], 'drake_geom_ros') == str(example['ours'])


@pytest.mark.processes
@pytest.mark.skipif(importlib.util.find_spec('pydrake') is None, reason='no pydrake')
def test_what_it_says_of_pydrake():
    expected = {entry['code']: str(entry['pydrake']) for entry in EXAMPLES}
    assert of_pydrake(DIFFERENCES, 'on_purpose') == expected


def listed():
    """Return (module, name) of all that the page calls missing."""
    return [
        (module, name)
        for entry in TABLE['missing']
        for module, text in entry.items()
        if module != 'why'
        for name in text.split()
    ]


def absent():
    """Yield (module, name or Class.method) of pydrake that this package does not have."""
    for module, names in recorded().items():
        for name, said in names.items():
            thing = getattr(ours(module), name, None)
            if thing is None:
                yield module, name
                continue
            # What a record holds is there once it is made.
            fields = getattr(thing, '__dataclass_fields__', ())
            for method in said if isinstance(said, dict) else ():
                if (
                    not hasattr(thing, method)
                    and method not in fields
                    and method
                    not in (
                        'name',
                        'value',  # of the members of an enumeration
                    )
                ):
                    yield module, f'{name}.{method}'


def test_all_that_is_missing_is_listed_and_nothing_else():
    assert sorted(listed()) == sorted(absent())
    assert len(set(listed())) == len(listed())


@pytest.mark.processes
def test_the_port_that_is_shown_runs():
    paths = os.pathsep.join([str(ROOT), os.environ.get('PYTHONPATH', '')])
    done = subprocess.run(
        [sys.executable, 'examples/port_of_a_diagram.py'],
        cwd=ROOT,
        env={**os.environ, 'PYTHONPATH': paths},
        capture_output=True,
        text=True,
        timeout=800,
    )
    assert done.returncode == 0, done.stderr
    assert ' m between ur5/' in done.stdout
