"""Diagrams: one a query, errors of nothing drawn as rounding, names that do not meet."""

from evidence.accuracy.records import ours, peer, some
from matplotlib import image

from drake_geom_ros.evidence.accuracy.diagrams import draw, drawn, level_names
from drake_geom_ros.evidence.accuracy.level_diagram import draw_levels


def test_a_picture_is_written_for_each_query(tmp_path):
    assert draw(some(), tmp_path) == ['signed_distance.png']
    picture = image.imread(tmp_path / 'signed_distance.png')
    assert picture.shape[0] > 400
    assert picture.shape[1] > 800
    # Not a blank sheet.
    assert picture[..., :3].std() > 0.05


def test_a_peer_that_answered_nothing_is_left_out(tmp_path):
    assert draw([ours('exact', (0.1, 1e-15)), peer('Coal')], tmp_path) == ['signed_distance.png']


def test_no_error_is_drawn_as_the_spacing_of_floats():
    record = ours('exact', (0.1, 1e-15))
    assert drawn(0.0, record) == record.rounding() > 0.0
    assert drawn(1e-3, record) == 1e-3
    assert drawn(1.8e308, record) == 10.0


def test_names_of_points_that_lie_close_are_one():
    points = [(1.0, 0.1, 'bound'), (9.0, 1e-15, 'fast'), (10.0, 2e-15, 'exact')]
    assert level_names(points) == [(1.0, 0.1, 'bound'), (9.0, 1e-15, 'fast to exact')]


def test_the_summary_shows_our_levels(tmp_path):
    assert draw_levels(some(), tmp_path) == ['levels.png']
    assert image.imread(tmp_path / 'levels.png')[..., :3].std() > 0.05
    assert draw_levels([peer('Coal', 0.1)], tmp_path) == []
