import numpy as np
from PIL import Image
from ros.demo import scenes

from drake_geom_ros.ros.demo.plots import draw_distances
from drake_geom_ros.ros.demo.recording import Recording


def _has(picture, colour, least):
    return (np.abs(picture.astype(int) - colour).sum(axis=2) < 30).sum() >= least


def test_the_curves_and_the_filter_changes_are_drawn(tmp_path):
    draw_distances(scenes.recording(), tmp_path / 'distances.png')
    picture = np.asarray(Image.open(tmp_path / 'distances.png').convert('RGB'))
    assert picture.shape[1] > 1000
    for colour in ((0x1F, 0x5F, 0xA8), (0x2A, 0x8A, 0x57), (0xC0, 0x39, 0x2B), (0x55,) * 3):
        assert _has(picture, colour, 100)


def test_a_change_of_the_filters_changes_the_picture(tmp_path):
    made = scenes.recording()
    draw_distances(made, tmp_path / 'with.png')
    made.changes = []
    draw_distances(made, tmp_path / 'without.png')
    with_changes = np.asarray(Image.open(tmp_path / 'with.png').convert('L'))
    without = np.asarray(Image.open(tmp_path / 'without.png').convert('L'))
    assert with_changes.shape != without.shape or (with_changes != without).any()


def test_an_empty_recording_is_drawn_empty(tmp_path):
    draw_distances(Recording(scenes.table()), tmp_path / 'distances.png')
    assert (tmp_path / 'distances.png').stat().st_size > 1000
