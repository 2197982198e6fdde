"""One frame is, two frames are."""

import pytest

from drake_geom_ros.common.counting import are, counted, were


@pytest.mark.parametrize(
    ('number', 'noun', 'words'),
    [
        (0, 'pair', '0 pairs were'),
        (1, 'TF frame', '1 TF frame was'),
        (2, 'mesh', '2 meshes were'),
        (3, 'geometry', '3 geometries were'),
    ],
)
def test_nouns_and_verbs_agree_with_their_number(number, noun, words):
    assert f'{counted(number, noun)} {were(number)}' == words
    assert are(number) == {'was': 'is', 'were': 'are'}[were(number)]
