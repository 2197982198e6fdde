"""Half spaces that overlap, in a node: yes or no, beside lists, in diagnostics, and for rules."""

import math

import numpy as np
import pytest
from live.live_scenes import live_scene
from live.plain_messages import echoed
from live.scene.test_scene_rules import Ruled
from live.services.test_queries import ABOUT_ALL, ask
from ros.scene_calls import poses as hand_at

from drake_geom_ros.replay import Finding, Judge, read_events
from drake_geom_ros.scene_files import to_yaml

TEXT = """
name: cell
sources: [arm]
frames:
- {name: hand, source: arm, static: false, pose: {position: [0, 0, 0.5]}}
geometries:
- {name: plane, source: arm, frame: hand, shape: {type: half_space}}
- {name: floor, shape: {type: half_space}}
proximity_rules:
- {name: down, set_a: arm, set_b: floor, level: stop, enter: 0.2, leave: 0.3}
"""
TOLD = (
    '1 pair of half spaces that overlap is in no list of distances or penetrations: '
    'arm::hand/plane and cell::world/floor; filter what does not count'
)
OVER, UPRIGHT = (1.0, 0, 0, 0), (0, 0, 0, 1.0)


def at(z, turn=OVER):
    return hand_at(['hand'], [(0, 0, z, *turn)], source='arm')


PLACES = {'apart': (at(0.1), False), 'in': (at(-0.1), True), 'upright': (at(5.0, UPRIGHT), True)}


@pytest.mark.parametrize('place', PLACES)
def test_services_say_yes_and_lists_say_what_is_not_in_them(place):
    live, (given, overlap) = live_scene(TEXT), PLACES[place]
    answers = {
        name: ask(live, handler, given) for name, handler in ABOUT_ALL.items() if name != 'points'
    }
    assert answers['collisions'].has_collisions == overlap
    assert len(answers['candidates'].id_a) == overlap
    for name in ('penetration', 'distances'):
        assert len(answers[name].result.id_a) == 0
        assert answers[name].message == (TOLD if overlap else '')
    assert answers['collisions'].message == answers['candidates'].message == ''


@pytest.mark.parametrize('place', PLACES)
def test_diagnostics_tell_them(place):
    live, (given, overlap) = live_scene(TEXT), PLACES[place]
    with live.editing() as scene:
        scene.poses.take(given)
        assert [t for t in scene.troubles() if 'half spaces' in t] == [TOLD] * overlap


def test_a_rule_is_entered_by_them(tmp_path):
    ruled = Ruled(TEXT)

    def decide(given):
        ruled.clock.now += 0.1
        with ruled.live.editing() as scene:
            scene.poses.take(given)
            ruled.events.look_at(scene, None, 0.0)
            (state,) = scene.rules.states()
        return state.is_entered, state.lowest

    def lowest(value):
        return pytest.approx(value, abs=1e-12)

    assert decide(at(0.5)) == (False, math.inf)  # beyond what rules look at
    assert decide(at(0.15)) == (True, lowest(0.15))
    assert decide(at(0.25)) == (True, lowest(0.25))
    assert decide(at(0.5)) == (False, math.inf)  # beyond what rules look at
    assert decide(at(0.5, (math.cos(1e-6), 0, 0, math.sin(1e-6)))) == (True, -math.inf)
    assert decide(at(5.0, UPRIGHT)) == (True, -math.inf)
    (event,) = ruled.topics.events.published[-1:]
    assert {event.geometry_a[0], event.geometry_b[0]} == {'arm::hand/plane', 'cell::world/floor'}
    assert (event.distance[0], event.error_bound[0]) == (-math.inf, 0.0)
    assert np.isnan(event.p_wca).all()
    assert not np.isnan(event.pose_a).any()
    with ruled.live.reading() as scene:
        (tmp_path / 'scene.yaml').write_text(to_yaml(scene.description()))
    (tmp_path / 'events.yaml').write_text(echoed(ruled.topics.events.published))
    judge = Judge(tmp_path / 'scene.yaml')
    told = [judge.verdict(e) for e in read_events(tmp_path / 'events.yaml') if e.has_pair]
    assert {each.finding for each in told} == {Finding.NOT_TO_BE_TOLD}
