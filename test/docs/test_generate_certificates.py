"""docs/certificates.md is what the pair table says."""

import re
import runpy

from conventions.source_tree import ROOT
from every import check

from drake_geom_ros.geometry._proximity.kernels.pair_table import ALL_ROWS, SHAPE_NAMES

GENERATOR = runpy.run_path(str(ROOT / 'docs/generate_certificates.py'))


def test_the_page_is_current():
    assert (ROOT / 'docs/certificates.md').read_text() == GENERATOR['certificates'](), (
        'run: python docs/generate_certificates.py'
    )


def pair_of(row):
    """Return the names of the shapes of a row of the pair table."""
    return f'{SHAPE_NAMES[row.type_a]} and {SHAPE_NAMES[row.type_b]}'


def test_every_row_says_why_in_two_sentences():
    page = GENERATOR['certificates']()

    def judge(row):
        assert len(re.findall(r'\.(?= [A-Z]|$)', row.certificate)) == 2
        assert pair_of(row) in page

    check(judge, ALL_ROWS, pair_of)
