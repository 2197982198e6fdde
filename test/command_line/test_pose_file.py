"""Pose files: the same poses from CSV and JSON, and each mistake with its place."""

import io

import pytest

from drake_geom_ros.command_line.pose_file import read_poses, write_poses
from drake_geom_ros.scene_files import SceneFileError

CSV = """\
time,frame,x,y,z,qx,qy,qz,qw
0.0,a,1,2,3,0,0,0,1
0.0,s::b,0,0,0,0,0,1,0
0.5,a,4,5,6,0,0,0,1
"""
HEADER = 'frame,x,y,z,qx,qy,qz,qw\n'


def plain(sets):
    return [
        (moment.time, {p.frame: p.X_PF.ToArray().tolist() for p in moment.poses})
        for moment in sets
    ]


def read(tmp_path, text, suffix='.csv'):
    path = tmp_path / f'poses{suffix}'
    path.write_text(text)
    return read_poses(path)


def test_rows_of_one_time_are_one_moment(tmp_path):
    assert plain(read(tmp_path, CSV)) == [
        (0.0, {'a': [1, 2, 3, 0, 0, 0, 1], 's::b': [0, 0, 0, 0, 0, 1, 0]}),
        (0.5, {'a': [4, 5, 6, 0, 0, 0, 1]}),
    ]


def test_without_times_all_rows_are_one_moment(tmp_path):
    rows = HEADER + 'a,1,2,3,0,0,0,1\nb,0,0,0,0,0,0,1\n'
    ((time, poses),) = plain(read(tmp_path, rows))
    assert time is None
    assert list(poses) == ['a', 'b']


def test_json_is_an_object_or_a_list_of_them(tmp_path):
    pose = '[1, 2, 3, 0, 0, 0, 1]'
    expected = {'a': [1, 2, 3, 0, 0, 0, 1]}
    assert plain(read(tmp_path, f'{{"a": {pose}}}', '.json')) == [(None, expected)]
    text = f'[{{"a": {pose}}}, {{"time": 2, "poses": {{"a": {pose}}}}}]'
    assert plain(read(tmp_path, text, '.json')) == [(None, expected), (2.0, expected)]


@pytest.mark.parametrize('suffix', ['.csv', '.json'])
def test_what_is_written_is_read_again(tmp_path, suffix):
    sets = read(tmp_path, CSV)
    written = io.StringIO()
    write_poses(sets, written, suffix)
    assert plain(read(tmp_path, written.getvalue(), suffix)) == plain(sets)


def test_moments_without_times_cannot_be_csv(tmp_path):
    sets = read(tmp_path, '[{}, {}]', '.json')
    with open(tmp_path / 'out.csv', 'w') as file, pytest.raises(SceneFileError, match='time each'):
        write_poses(sets, file, '.csv')


@pytest.mark.parametrize(
    ('suffix', 'text', 'where', 'why'),
    [
        ('.csv', '', ':1', 'columns'),
        ('.csv', 'frame,x\n', ':1', 'columns'),
        ('.csv', HEADER + 'a,1,2,3,0,0,0\n', ':2', '8 values'),
        ('.csv', HEADER + 'a,1,2,3,0,0,0,1,9\n', ':2', '8 values'),
        ('.csv', HEADER + 'a,1,2,nan,0,0,0,1\n', ':2', 'finite'),
        ('.csv', HEADER + 'a,1,2,three,0,0,0,1\n', ':2', 'three'),
        ('.csv', HEADER + 'a,1,2,3,0,0,0,1.1\n', ':2', 'norm'),
        ('.csv', HEADER + 'a,1,2,3,0,0,0,1\n' * 2, ':3', 'twice'),
        ('.json', '{"a":', ':1', 'JSON'),
        ('.json', '[' * 100000, '', 'deep'),
        ('.json', '[1]', '[0]', 'object'),
        ('.json', '{"a": [1, 2]}', 'a', '7 numbers'),
        ('.json', '[{"a": [1, 2, 3, 0, 0, 0, null]}]', '[0].a', 'finite'),
        ('.json', '{"a": [1, 2, 3, 0, 0, 0, true]}', 'a', 'finite'),
        ('.json', '{"a": [1, 2, 3, 0, 0, 0, 1e999]}', 'a', 'finite'),
        (
            *('.json', '{"a": [0, 0, 0, 0, 0, 0, 1], "a": [9, 0, 0, 0, 0, 0, 1]}'),
            *('poses.json: a: ', 'twice'),
        ),
        ('.json', '{"time": 1, "time": 2, "poses": {}}', 'time', 'twice'),
        ('.txt', '', '', '.csv'),
    ],
)
def test_a_mistake_is_named_with_its_place(tmp_path, suffix, text, where, why):
    with pytest.raises(SceneFileError) as error:
        read(tmp_path, text, suffix)
    assert f'poses{suffix}' in str(error.value)
    assert where in str(error.value)
    assert why in str(error.value)
