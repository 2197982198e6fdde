from ros.demo import scenes

from drake_geom_ros.ros.demo.report import write_report


def test_three_files_and_what_they_hold(tmp_path):
    said = write_report(scenes.recording(), tmp_path / 'out' / 'demo')
    names = {path.name for path in (tmp_path / 'out' / 'demo').iterdir()}
    assert names == {'results.csv', 'distances.png', 'closest.png'}
    assert '120 rows of 40 results' in said[0]
    assert 'deepest penetration 2.00 mm, 2 filter changes' in said[1]
    assert 'left::hand - right::hand' in said[2]
    assert 'cycle p50 20.50 ms' in said[3]


def test_without_a_closest_moment_the_picture_is_left_out(tmp_path):
    made = scenes.recording()
    made.approach = None
    write_report(made, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {'results.csv', 'distances.png'}
