import dataclasses

import numpy as np
import pytest
from PIL import Image
from ros.demo import demo_scenes as scenes

from drake_geom_ros.ros.demo.picture import draw_closest


def counts_of(path):
    """Count pixels that are mostly blue (left), orange (right), green (objects), red (normal)."""
    rgb = np.asarray(Image.open(path).convert('RGB')).astype(int)
    r, g, b = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    return {
        'left': ((b > r + 60) & (b > g + 20)).sum(),
        'right': ((r > b + 80) & (g > b + 30)).sum(),
        'objects': ((g > r + 30) & (g > b + 20)).sum(),
        'normal': ((r > g + 110) & (r > b + 70)).sum(),
    }


def test_both_robots_the_objects_and_the_normal_are_seen(tmp_path):
    draw_closest(scenes.recording(), scenes.DESCRIPTION, tmp_path / 'closest.png')
    counts = counts_of(tmp_path / 'closest.png')
    assert counts['left'] > 5000
    assert counts['right'] > 5000
    assert counts['objects'] > 500
    assert counts['normal'] > 300


@pytest.mark.parametrize('upwards', [False, True])
def test_a_pair_in_contact_is_drawn_too(tmp_path, upwards):
    made = scenes.recording()
    normal = np.array([0.0, 0.0, 1.0]) if upwards else made.approach.nhat_BA_W
    made.approach = dataclasses.replace(made.approach, distance=-0.002, nhat_BA_W=normal)
    draw_closest(made, scenes.DESCRIPTION, tmp_path / 'closest.png')
    assert counts_of(tmp_path / 'closest.png')['normal'] > 300


def test_without_a_closest_moment_nothing_is_drawn(tmp_path):
    made = scenes.recording()
    made.approach = None
    with pytest.raises(ValueError, match='no closest moment'):
        draw_closest(made, scenes.DESCRIPTION, tmp_path / 'closest.png')
