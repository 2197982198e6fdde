"""`replay`: recorded against recomputed, and whether the answer still exceeds its tolerance."""

import dataclasses
import math

import numpy as np
import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import SignedDistanceResults
from drake_geom_ros.replay import Opinion, read, recorded, write


@pytest.fixture
def path(tmp_path):
    """Return a replay file of the ball beside the post."""
    query = OpenedScene(str(ROOT / 'scenes/minimal.yaml')).query
    results = query.ComputeSignedDistancePairwiseClosestPoints(0.5, accuracy='balanced')
    replay = recorded(query, results, 0, 'balanced', 0.5)
    wide = dataclasses.replace(replay.answer, error_bound=0.25, breaks_promise=True)
    path = tmp_path / 'case.json'
    write(dataclasses.replace(replay, answer=wide), path)
    return path


def test_a_promise_that_is_kept_now(path, capsys):
    assert main(['replay', str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == ['scene::world/post', 'scene::ball/ball']
    assert lines[2] == 'accuracy balanced, pairs within 0.5 m, no hint'
    assert lines[3].startswith('recorded with python ')
    table = {line[:26].strip(): line[26:].split() for line in lines[5:-1]}
    assert [float(text) for text in table['distance [m]']] == pytest.approx([0.35, 0.35])
    assert table['distance [m]'][0] == table['distance [m]'][1]
    assert float(table['error_bound [m]'][0]) == 0.25
    assert float(table['error_bound [m]'][1]) < 1e-13
    assert float(table['promised_error_bound [m]'][0]) == pytest.approx(1e-6, rel=1e-6)
    assert table['method'] == ['closed_form', 'closed_form']
    assert len(table) == 3 + 9 + 1
    assert lines[-1].startswith('the answer meets its tolerance: error bound ')


def test_a_promise_that_is_still_broken(path, capsys, monkeypatch):
    everything = np.ones(1, dtype=bool)
    monkeypatch.setattr(SignedDistanceResults, 'breaks_promise', lambda results: everything)
    assert main(['replay', str(path)]) == 1
    assert 'the answer still exceeds its tolerance: error bound' in capsys.readouterr().out


def test_a_hint_and_numbers_that_are_none_are_shown(path, capsys):
    replay = read(path)
    question = dataclasses.replace(replay.question, hint=(0.0, 0.0, 1.0))
    answer = dataclasses.replace(replay.answer, distance=math.nan)
    path.unlink()
    write(dataclasses.replace(replay, question=question, answer=answer), path)
    assert main(['replay', str(path)]) == 0
    output = capsys.readouterr().out
    assert 'the hint of the file' in output
    assert 'nan' in output


@pytest.mark.parametrize('content', ['{}', '', 'scene'])
def test_a_bad_file_is_named_in_one_line(path, capsys, content):
    path.write_text(content)
    assert main(['replay', str(path)]) == 2
    output, errors = capsys.readouterr()
    assert output == ''
    assert errors.count('\n') == 1
    assert 'case.json' in errors


def test_no_file_at_all(tmp_path, capsys):
    assert main(['replay', str(tmp_path / 'nowhere.json')]) == 2
    assert 'nowhere.json' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('distance', 'code', 'told'),
    [(0.35, 0, 'it agrees with FCL 1: 0.35 m'), (0.4, 1, 'it still differs from FCL 1: 0.4 m')],
)
def test_another_opinion_is_compared_with_the_answer_of_now(path, capsys, distance, code, told):
    replay = dataclasses.replace(read(path), opinion=Opinion('FCL 1', distance, 1e-4))
    path.unlink()
    write(replay, path)
    assert main(['replay', str(path)]) == code
    assert capsys.readouterr().out.splitlines()[-1] == f'{told} within 0.0001 m'
