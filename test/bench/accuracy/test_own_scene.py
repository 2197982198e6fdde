"""What each accuracy would cost for a scene that somebody gives."""

import math

from conventions.source_tree import ROOT

from bench.accuracy.__main__ import main
from bench.accuracy.own_scene import costs_of_scene


def test_each_accuracy_of_a_scene_has_a_time_and_a_gain(capsys):
    scene = ROOT / 'scenes/two_pandas.yaml'
    assert main(['--scene', str(scene)]) == 0
    title, head, *rows = capsys.readouterr().out.splitlines()
    assert str(scene) in title
    assert head.split() == ['accuracy', 'us', 'a', 'pair', 'gain']
    table = {name: (float(time), float(gain)) for name, time, gain in map(str.split, rows)}
    assert list(table) == ['bound', '0.01', 'fast', 'balanced', 'exact']
    assert all(0.0 < time < math.inf and gain > 0.0 for time, gain in table.values())
    assert table['exact'][1] == 1.0


def test_a_scene_without_near_pairs_says_so(tmp_path):
    scene = tmp_path / 'lone.yaml'
    scene.write_text(
        'sources: [s]\ngeometries: [{name: a, source: s, shape: {type: sphere, radius: 1}}]\n'
    )
    assert 'no two bodies' in costs_of_scene(scene)[0]


def test_a_scene_that_is_not_there_is_bad_input(capsys):
    assert main(['--scene', 'nowhere.yaml']) == 2
    assert 'nowhere.yaml' in capsys.readouterr().err
