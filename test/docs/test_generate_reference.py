"""docs/reference.md is what the definitions say."""

import runpy

import pytest
from conventions.source_tree import ROOT

GENERATOR = runpy.run_path(str(ROOT / 'docs/generate_reference.py'))


def test_the_reference_is_current():
    assert (ROOT / 'docs/reference.md').read_text() == GENERATOR['reference'](), (
        'run: python docs/generate_reference.py'
    )


def test_it_names_every_definition_and_every_field():
    text = GENERATOR['reference']()
    for path in (ROOT / 'msg_defs').glob('*/*.*'):
        assert path.stem in text
    assert '| `max_distance` | `float64` |' in text
    assert '| `METHOD_CLOSED_FORM=1` | `uint8` |' in text
    assert '### compute_signed_distance_to_point (`ComputeSignedDistanceToPoint`)' in text


def test_a_line_that_is_no_field_is_seen(tmp_path):
    broken = tmp_path / 'Broken.msg'
    broken.write_text('# Text.\n\nuint8\n')
    with pytest.raises(ValueError, match='uint8'):
        GENERATOR['_section'](broken, 'Broken')
