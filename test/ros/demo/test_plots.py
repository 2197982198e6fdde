import warnings

import numpy as np
from PIL import Image
from ros.demo import demo_scenes as scenes

from drake_geom_ros.ros.demo.plots import draw_distances
from drake_geom_ros.ros.demo.recording import FilterChange, Recording, RuleEvent


def _has(picture, colour, least):
    return (np.abs(picture.astype(int) - colour).sum(axis=2) < 30).sum() >= least


def test_the_curves_and_the_filter_changes_are_drawn(tmp_path):
    draw_distances(scenes.recording(), tmp_path / 'distances.png')
    picture = np.asarray(Image.open(tmp_path / 'distances.png').convert('RGB'))
    assert picture.shape[1] > 1000
    for colour in ((0x1F, 0x5F, 0xA8), (0xD9, 0x82, 0x2B), (0xA6, 0x3F, 0x00), (0x55,) * 3):
        assert _has(picture, colour, 100)


def test_a_change_of_the_filters_changes_the_picture(tmp_path):
    made = scenes.recording()
    draw_distances(made, tmp_path / 'with.png')
    made.changes = []
    draw_distances(made, tmp_path / 'without.png')
    with_changes = np.asarray(Image.open(tmp_path / 'with.png').convert('L'))
    without = np.asarray(Image.open(tmp_path / 'without.png').convert('L'))
    assert with_changes.shape != without.shape or (with_changes != without).any()


def test_events_of_rules_are_marked_in_the_colour_of_their_level(tmp_path):
    made, colours = scenes.recording(), {'slow': (0xFF, 0x78, 0x00), 'stop': (0xFF, 0x00, 0x00)}
    for level in colours:
        made.events = [
            RuleEvent(101.0, 'near', level, True, 0.1),
            RuleEvent(101.5, 'near', level, False, 0.2),
            RuleEvent(102.0, 'blind', level, True, np.nan),
        ]
        draw_distances(made, tmp_path / f'{level}.png')
        picture = np.asarray(Image.open(tmp_path / f'{level}.png').convert('RGB'))
        for each, other in colours.items():
            assert _has(picture, other, 60) == (each == level), (level, each)


def test_an_empty_recording_is_drawn_empty(tmp_path):
    draw_distances(Recording(scenes.table()), tmp_path / 'distances.png')
    assert (tmp_path / 'distances.png').stat().st_size > 1000


def test_a_long_recording_lists_its_last_changes(tmp_path):
    """Ten minutes have a hundred: all of them, as text, left no room for the curves."""
    made = scenes.recording()
    last = made.pairs[-1].time
    made.changes = [FilterChange(last - 0.01 * k, f'change {100 - k}') for k in range(100)][::-1]
    for k in range(40):  # contacts come and go
        made.add_penetrations(
            last + 0.1 * k, np.array([1]), np.array([2]), np.array([k % 2 * 1e-3])
        )
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        draw_distances(made, tmp_path / 'distances.png')
    picture = np.asarray(Image.open(tmp_path / 'distances.png').convert('RGB'))
    assert _has(picture, (0x1F, 0x5F, 0xA8), 100)


def test_what_changed_before_the_recording_begins_is_left_out(tmp_path):
    made = scenes.recording()
    draw_distances(made, tmp_path / 'plain.png')
    early = FilterChange(made.pairs[0].time - 100.0, 'early')
    made.changes = [*made.changes, early]
    draw_distances(made, tmp_path / 'early.png')
    assert (tmp_path / 'plain.png').read_bytes() == (tmp_path / 'early.png').read_bytes()
