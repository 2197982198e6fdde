import dataclasses

import numpy as np
import pytest
from PIL import Image
from ros.demo import demo_scenes as scenes

from drake_geom_ros.ros.demo.picture import draw_closest


def _counts(path):
    """How many pixels are mostly blue (left), orange (right), green (objects), red (normal)."""
    rgb = np.asarray(Image.open(path).convert('RGB')).astype(int)
    r, g, b = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    return {
        'left': ((b > r + 60) & (b > g + 30)).sum(),
        'right': ((r > b + 80) & (g > b + 30)).sum(),
        'objects': ((g > r + 30) & (g > b + 30)).sum(),
        'normal': ((r > g + 110) & (r > b + 70)).sum(),
    }


def test_both_robots_the_objects_and_the_normal_are_seen(tmp_path):
    draw_closest(scenes.recording(), tmp_path / 'closest.png')
    counts = _counts(tmp_path / 'closest.png')
    assert counts['left'] > 5000
    assert counts['right'] > 5000
    assert counts['objects'] > 500
    assert counts['normal'] > 300


def test_a_pair_in_contact_is_drawn_too(tmp_path):
    made = scenes.recording()
    made.approach = dataclasses.replace(made.approach, distance=-0.002)
    draw_closest(made, tmp_path / 'closest.png')
    assert _counts(tmp_path / 'closest.png')['normal'] > 300


def test_without_a_closest_moment_nothing_is_drawn(tmp_path):
    made = scenes.recording()
    made.approach = None
    with pytest.raises(ValueError, match='no closest moment'):
        draw_closest(made, tmp_path / 'closest.png')
