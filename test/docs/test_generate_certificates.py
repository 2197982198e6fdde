"""docs/certificates.md is what the pair table says."""

import dataclasses
import runpy

import pytest
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


def test_the_page_names_every_pair():
    page = GENERATOR['certificates']()

    def judge(row):
        assert pair_of(row) in page

    check(judge, ALL_ROWS, pair_of)


def test_every_reason_is_that_of_a_pair():
    reasons = {each for each in GENERATOR.values() if isinstance(each, GENERATOR['Reason'])}
    reasons |= set(GENERATOR['_REASONS'].values())
    assert reasons == {GENERATOR['reason_of'](row) for row in ALL_ROWS}


def test_a_kernel_without_a_reason_is_refused():
    row = dataclasses.replace(ALL_ROWS[0], kernel='closed_forms.tori.sphere_torus')
    with pytest.raises(KeyError, match='tori'):
        GENERATOR['reason_of'](row)
