"""The README: what it shows runs, and prints what it says."""

import re
from pathlib import Path

import pytest

from drake_geom_ros.geometry._proximity.pair_table import PAIR_TABLE, SHAPE_NAMES

ROOT = Path(__file__).parents[1]
README = (ROOT / 'README.md').read_text()


def block(language):
    """Return the README's only code block in a language."""
    (found,) = re.findall(rf'^```{language}\n(.*?)^```$', README, re.S | re.M)
    return found


def test_the_scene_file_is_the_one_that_ships():
    assert block('yaml') == (ROOT / 'scenes/minimal.yaml').read_text()


def test_the_core_example_prints_what_its_last_line_says(capsys):
    exec(compile(block('python'), 'README.md', 'exec'), {})
    printed = capsys.readouterr().out.strip()
    assert block('python').rstrip().endswith(f'# {printed}')


def test_the_support_table_is_the_pair_table():
    rows = [
        f'| {SHAPE_NAMES[row.type_a]} | {SHAPE_NAMES[row.type_b]} | {row.method.words} '
        f'| {row.worst_error:.0e} |'
        for row in PAIR_TABLE
    ]
    assert '\n'.join(['| A | B | method | worst error |', '|---|---|---|---|', *rows]) in README


@pytest.mark.parametrize('link', re.findall(r'\]\(([^)#]+)\)', README))
def test_links_lead_somewhere(link):
    assert (ROOT / link).exists()
