"""A recording in which half spaces overlap: told, and no motion is proved."""

import numpy as np
from recordings import recorder
from recordings.test_clearance import poses

from drake_geom_ros.recordings import clearance
from drake_geom_ros.recordings.comparing import compare_runs

SCENE = """
sources: [s]
frames: [{name: a, source: s}, {name: b, source: s}]
geometries:
- {name: floor, source: s, shape: {type: half_space}}
- {name: plane, source: s, frame: a, shape: {type: half_space}}
- {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
"""
OVER, TILTED, BALL = (0, 0, 4, 1, 0, 0, 0), (0, 0, 4, 0.8, 0.0, 0.0, 0.6), (0, 0, 1, 0, 0, 0, 1)
CLEAR, CONTACT = 1, 2


def certified(tmp_path, states):
    (tmp_path / 'scene.yaml').write_text(SCENE)
    times = [0.1 * (1 + k) for k in range(len(states))]
    recorder.record(tmp_path / 'run', poses(times, ['a', 'b'], np.array(states, float)))
    return clearance(tmp_path / 'run', tmp_path / 'scene.yaml', certify=0.01)


def test_what_rests_is_clear_where_they_are_apart(tmp_path):
    found = certified(tmp_path, [(OVER, BALL)] * 3)
    assert found['all'].motion.tolist()[1:] == [CLEAR, CLEAR]
    assert not [t for t in found.troubles if 'half spaces' in t.words]


def test_nothing_is_clear_where_they_overlap(tmp_path):
    states = [(TILTED, BALL), (TILTED, BALL), (TILTED, (0, 0, 2, 0, 0, 0, 1))]
    found = certified(tmp_path, states)
    assert found['all'].motion.tolist()[1:] == [CONTACT, CONTACT]
    assert (found['all'].distance == -np.inf).all()
    least = min(found.moments['all'], key=lambda close: close.lower_bound)
    assert least.moment.distance == -np.inf
    assert {least.moment.name_A, least.moment.name_B} == {'s::world/floor', 's::a/plane'}
    assert [t.words for t in found.troubles if 'half spaces' in t.words]


def test_of_two_runs_the_one_in_which_planes_cross_is_nearer_by_infinity(tmp_path):
    """Endless overlaps are not taken for what is farther than asked."""
    crossing, apart = [(TILTED, BALL)] * 3, [(OVER, BALL)] * 3
    for name in ('crossing', 'apart'):
        (tmp_path / name).mkdir()
    one, other = certified(tmp_path / 'crossing', crossing), certified(tmp_path / 'apart', apart)
    (both,) = compare_runs(one, other)
    assert both.nearer(allow_incomplete=True)[0] == np.inf
    assert {both.pairs[0].name_A, both.pairs[0].name_B} == {'s::world/floor', 's::a/plane'}
    (same,) = compare_runs(one, one)
    assert same.nearer(allow_incomplete=True)[0] == 0.0
