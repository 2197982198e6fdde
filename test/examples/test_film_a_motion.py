"""The film of two arms: as many pictures as were asked for, and none is like the one before."""

import itertools

import numpy as np
import pytest
from PIL import Image, ImageSequence

from examples.test_examples import EXAMPLES, output

pytestmark = pytest.mark.processes


def test_it_films_two_arms(tmp_path):
    film = tmp_path / 'arms.gif'
    printed = output(
        EXAMPLES / 'film_a_motion.py', '--frames', '4', '--width', '160', '--out', film
    )
    assert printed.startswith('4 pictures; the arms are at least 0.')
    with Image.open(film) as image:
        pictures = [np.asarray(each.convert('RGB')) for each in ImageSequence.Iterator(image)]
    assert len(pictures) == 4
    assert all((a != b).any() for a, b in itertools.pairwise(pictures))
