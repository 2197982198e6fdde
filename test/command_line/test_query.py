"""`query`: files in, one answer a moment out."""

import csv
import json
from pathlib import Path

import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.command_line.program import main

SCENE = str(ROOT / 'scenes/minimal.yaml')
POSES = """\
time,frame,x,y,z,qx,qy,qz,qw
0.0,ball,0.5,0,0.3,0,0,0,1
0.1,ball,0.5,0,0.05,0,0,0,1
"""


@pytest.fixture
def poses(tmp_path):
    path = tmp_path / 'poses.csv'
    path.write_text(POSES)
    return str(path)


def ask(capsys, *arguments):
    assert main(['query', SCENE, *arguments]) == 0
    return capsys.readouterr().out


def test_each_time_has_its_answer(capsys, poses):
    rows = list(
        csv.DictReader(ask(capsys, '--poses', poses, '--max-distance', '0.3').splitlines())
    )
    floor = [(r['time'], float(r['distance'])) for r in rows if 'floor' in r['geometry_a']]
    assert floor == [('0.0', pytest.approx(0.2)), ('0.1', pytest.approx(-0.05))]


def test_json_holds_empty_answers_too(capsys, poses):
    answers = json.loads(ask(capsys, '--poses', poses, '--what', 'penetration', '--format=json'))
    assert [(a['time'], len(a['rows'])) for a in answers] == [(0.0, 0), (0.1, 1)]
    assert answers[1]['rows'][0]['depth'] == pytest.approx(0.05)


def test_collisions_are_one_row_a_moment(capsys, poses):
    rows = list(csv.DictReader(ask(capsys, '--poses', poses, '--what=collisions').splitlines()))
    assert [(r['time'], r['has_collisions']) for r in rows] == [('0.0', 'False'), ('0.1', 'True')]


@pytest.mark.parametrize(
    ('name', 'text'), [('p.csv', 'x,y,z\n0.5,0,1.3\n'), ('p.json', '[[0.5, 0, 1.3]]')]
)
def test_points_come_from_csv_or_json(capsys, tmp_path, name, text):
    (tmp_path / name).write_text(text)
    output = ask(
        capsys, '--what=points', '--points', str(tmp_path / name), '--max-distance', '0.25'
    )
    (row,) = csv.DictReader(output.splitlines())
    assert (row['point_index'], row['geometry']) == ('0', 'scene::ball/ball')
    assert float(row['distance']) == pytest.approx(0.2)


@pytest.mark.parametrize(
    ('name', 'text'),
    [
        ('p.csv', 'x,y\n1,2\n'),
        ('p.csv', 'x,y,z\n1,2,three\n'),
        ('p.csv', 'x,y,z\n1,2\n'),
        ('p.json', '[1, 2]'),
        ('p.json', '{'),
        ('p.csv', 'x,y,z\n1,2,nan\n'),
    ],
)
def test_points_that_are_none_are_refused(capsys, tmp_path, name, text):
    (tmp_path / name).write_text(text)
    assert main(['query', SCENE, '--what=points', '--points', str(tmp_path / name)]) == 2
    said = capsys.readouterr().err
    assert 'point' in said
    assert 'NoneType' not in said


def test_the_answer_goes_to_a_file(capsys, tmp_path):
    output = tmp_path / 'out.csv'
    assert ask(capsys, '--out', str(output)) == ''
    assert 'scene::ball/ball' in output.read_text()


def test_bad_input_leaves_an_old_answer_alone(capsys, tmp_path):
    poses, output = tmp_path / 'poses.json', tmp_path / 'out.csv'
    poses.write_text('[{"ball": [0, 0, 1, 0, 0, 0, 1]}, {"bell": [0, 0, 1, 0, 0, 0, 1]}]')
    output.write_text('old')
    assert main(['query', SCENE, '--poses', str(poses), '--out', str(output)]) == 2
    assert '[1].bell' in capsys.readouterr().err
    assert output.read_text() == 'old'


def test_nothing_is_answered_while_a_frame_has_no_pose(capsys, tmp_path):
    scene, poses = tmp_path / 'waits.yaml', tmp_path / 'poses.json'
    scene.write_text(Path(SCENE).read_text().replace(', pose: {position: [0.5, 0, 1]}', ''))
    assert main(['query', str(scene)]) == 2
    assert 'waits.yaml: these frames have no pose: scene::ball;' in capsys.readouterr().err
    poses.write_text('{"ball": [0.5, 0, 0.3, 0, 0, 0, 1]}')
    assert main(['query', str(scene), '--poses', str(poses), '--what=collisions']) == 0


@pytest.mark.parametrize('what', ['penetration', 'candidates', 'collisions'])
def test_a_limit_that_would_be_ignored_is_refused(capsys, what):
    assert main(['query', SCENE, '--what', what, '--max-distance', '0.5']) == 2
    said = capsys.readouterr().err
    assert '--max-distance goes with --what distance, least, nearest, points;' in said


@pytest.mark.parametrize('what', ['distance', 'penetration', 'candidates', 'collisions'])
def test_half_spaces_that_overlap_are_told_beside_a_list(capsys, tmp_path, what):
    scene = tmp_path / 'planes.yaml'
    scene.write_text(
        'frames: [{name: f, pose: {position: [0, 0, 1]}}]\ngeometries:\n'
        '- {name: floor, shape: {type: half_space}}\n'
        '- {name: plane, frame: f, shape: {type: half_space}}\n'
    )
    assert main(['query', str(scene), '--what', what]) == 0
    answer, told = capsys.readouterr()
    if what in ('distance', 'penetration'):
        assert len(answer.splitlines()) == 1
        assert told == (
            'scene::world/floor and scene::f/plane are half spaces that overlap, and in no list '
            'of distances or penetrations: ask for collisions, or filter the pair\n'
        )
    else:
        assert (len(answer.splitlines()), told) == (2, '')


@pytest.mark.parametrize(
    ('here', 'in_batches'), [('distance', 'within'), ('collisions', 'collision')]
)
def test_the_words_of_batch_ask_the_same(capsys, here, in_batches):
    printed = []
    for word in (here, in_batches):
        assert main(['query', str(ROOT / 'scenes/minimal.yaml'), '--what', word]) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1] != ''


@pytest.mark.parametrize(
    ('name', 'text', 'options', 'why'),
    [
        ('no.csv', POSES.splitlines()[0] + '\n', ['--poses'], 'no moment in it'),
        ('no.json', '[]', ['--poses'], 'no moment in it'),
        ('no.csv', 'x,y,z\n', ['--what', 'points', '--points'], 'no point in it'),
        ('no.json', '[]', ['--what', 'points', '--points'], 'no point in it'),
    ],
)
def test_a_question_about_nothing_is_no_answer(capsys, tmp_path, name, text, options, why):
    (tmp_path / name).write_text(text)
    assert main(['query', SCENE, *options, str(tmp_path / name)]) == 2
    output, errors = capsys.readouterr()
    assert output == ''
    assert why in errors


def test_between_asks_about_pairs_of_two_sets_alone(capsys, poses):
    timed = ask(capsys, '--poses', poses, '--between', 'ball:floor').splitlines()
    found = [(r['time'], r['geometry_a'], r['geometry_b']) for r in csv.DictReader(timed)]
    pair = ('scene::world/floor', 'scene::ball/ball')
    assert found == [('0.0', *pair), ('0.1', *pair)]
    both = ask(capsys, '--between', 'ball:floor', '--between', 'ball:post').splitlines()
    assert {r['geometry_a'] for r in csv.DictReader(both)} == {pair[0], 'scene::world/post'}


def test_between_keeps_the_pairs_of_frames_that_are_posed_later(capsys, tmp_path, poses):
    scene = tmp_path / 'scene.yaml'
    scene.write_text(
        'frames: [{name: ball}, {name: wall, pose: {position: [1, 0, 0]}}]\n'
        'geometries:\n'
        '- {name: ball, frame: ball, shape: {type: sphere, radius: 0.1}}\n'
        '- {name: wall, frame: wall, shape: {type: box, size: [0.2, 1, 1]}}\n'
        '- {name: floor, shape: {type: half_space}}\n'
    )
    assert main(['query', str(scene), '--poses', poses, '--between', 'ball:wall']) == 0
    rows = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    assert [float(r['distance']) for r in rows] == [pytest.approx(0.3)] * 2


@pytest.mark.parametrize(
    ('arguments', 'said'),
    [
        (['--between', 'ball:nothing'], "'nothing' stands for no geometry"),
        (['--between', 'floor:post'], 'no pair that queries report'),
        (['--between', 'ball'], 'must be two names or patterns, as left:right'),
        (['--between', 'ball:floor', '--what', 'points', '--points', '-'], '--what points'),
    ],
)
def test_between_that_leaves_no_pair_is_refused(capsys, arguments, said):
    assert main(['query', SCENE, *arguments]) == 2
    assert said in capsys.readouterr().err
