"""Planning scenes of MoveIt, full and as differences, and what their matrix allows."""

import math
from itertools import combinations
from types import SimpleNamespace as Plain

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.inputs.test_planning_scene import ARM, box, pairs, place, state
from live.live_scenes import Clock, live_scene
from live.moveit_messages import (
    REMOVE,
    attached_object,
    ball,
    collision_object,
    matrix,
    octomap_of,
    planning_scene,
    robot_state,
)

from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.sensed_maps import Cells

LINKS = ['base', 'hand', 'finger']
CELLS = Cells.of_points([[1.0, 1.0, 1.0]], 0.5)
NAMES = [*LINKS, 'a', 'b', 'later']


@pytest.fixture
def live():
    return live_scene(ARM, Clock())


@pytest.fixture
def moveit(live):
    return PlanningSceneInput(live)


def short(live):
    """Return the reported pairs by the names of frames."""
    return {frozenset(name.partition('/')[0] for name in pair) for pair in pairs(live)}


def test_an_object_that_comes_again_keeps_its_ids(live, moveit):
    message = planning_scene([box('a', 1.0)], [attached_object('hand', box('b'))])
    moveit.take_scene(message)
    with live.reading() as scene:
        before = scene.model.version, dict(scene.model.names.frame_names)
    moveit.take_scene(message)
    with live.reading() as scene:
        assert (scene.model.version, dict(scene.model.names.frame_names)) == before
    moveit.take_scene(planning_scene([box('a', 1.0, primitives=[ball(0.2)])]))
    with live.reading() as scene:
        assert scene.model.version > before[0]


def test_a_diff_adds_and_a_full_scene_replaces(live, moveit):
    moveit.take_scene(planning_scene([box('a', 1.0)], [attached_object('hand', box('b'))]))
    moveit.take_scene(planning_scene([box('c', 2.0)]))
    assert [place(live, name)[0] for name in 'abc'] == [1.0, 0.0, 2.0]
    done = moveit.take_scene(planning_scene([box('c', 3.0)], is_diff=False))
    assert '1 object in the world, 0 attached' in done
    assert place(live, 'c') == [3.0, 0.0, 0.0]


def test_a_state_that_is_no_diff_replaces_what_is_attached(live, moveit):
    moveit.take_scene(planning_scene([box('a')], [attached_object('hand', box('b'))]))
    scene = planning_scene(attached=[attached_object('hand', box('c'))], state_is_diff=False)
    assert '1 object in the world, 1 attached' in moveit.take_scene(scene)
    assert not any('b' in pair for pair in short(live))
    held = moveit.take_scene(planning_scene(is_diff=False, state_is_diff=True))
    assert '0 objects in the world, 1 attached' in held


def test_grasp_and_release_in_one_message_each(live, moveit):
    moveit.take_scene(planning_scene([box('a', 1.0)]))
    grasp = attached_object('hand', collision_object('a'))
    moveit.take_scene(planning_scene([collision_object('a', REMOVE)], [grasp]))
    assert frozenset(['hand', 'a']) not in short(live)
    release = attached_object('hand', collision_object('a', REMOVE))
    moveit.take_scene(planning_scene([box('a', 4.0)], [release]))
    assert place(live, 'a') == [4.0, 0.0, 0.0]
    assert frozenset(['hand', 'a']) in short(live)


def test_an_object_may_stand_on_one_of_the_same_message(live, moveit):
    moveit.take_scene(planning_scene([box('a', 1.0), box('b', 1.0, frame='a')]))
    assert place(live, 'b') == [2.0, 0.0, 0.0]


def test_what_is_ignored_is_reported(moveit):
    done = moveit.take_scene(
        planning_scene(
            joints={'j': 0.0}, fixed_frame_transforms=[Plain()], object_colors=[Plain()],
            allowed=matrix(['hand', 'nobody'], [('hand', 'nobody')]),
            link_padding=[Plain(link_name='hand', padding=0.0)],
            link_scale=[Plain(link_name='hand', scale=1.0)],
        )
    )  # fmt: skip
    for note in (
        'values of j are',
        'fixed_frame_transforms',
        'object_colors',
        'nobody is',
    ):
        assert note in done


def uneven():
    bad = matrix(['hand', 'finger'])
    bad.entry_values[0].enabled.pop()
    return bad


@pytest.mark.parametrize(
    ('message', 'reason'),
    [
        (planning_scene([box('a'), box('b', frame='hnd')]), "object 'b': There is no frame 'hnd'"),
        (planning_scene([box('a')], allowed=uneven()), "the row of 'hand' holds 1 values for 2"),
        (planning_scene(allowed=matrix(['hand', 'hand'])), "entry_names holds 'hand' twice"),
        (
            planning_scene([box('a')], octomap=octomap_of(None, id='OcTree', data=b'a')),
            'world.octomap: ',
        ),
        (
            planning_scene([box('a')], octomap=octomap_of(CELLS, frame='hnd')),
            "world.octomap: There is no frame 'hnd'",
        ),
        (
            planning_scene([box('a')], link_padding=[Plain(link_name='hand', padding=math.nan)]),
            "link_padding of 'hand' is nan",
        ),
        (
            planning_scene([box('a')], link_scale=[Plain(link_name='hand', scale=math.inf)]),
            "link_scale of 'hand' is inf",
        ),
        (
            planning_scene([box('a')], state=robot_state({'j1': 0.0}, position=[])),
            'position holds 0 numbers for 1 names',
        ),
        (
            planning_scene(
                attached=[attached_object('hand', collision_object('x', REMOVE))],
                state_is_diff=False,
            ),
            "object 'x': REMOVE in a robot_state that is no diff",
        ),
        (planning_scene([box('a')], [attached_object('hand', box('a'))]), 'is attached'),
    ],
)
def test_a_scene_is_taken_whole_or_not_at_all(live, moveit, message, reason):
    moveit.take_scene(planning_scene([box('c')], allowed=matrix(['c', 'hand'], [('c', 'hand')])))
    before = state(live)
    with pytest.raises(RuntimeError) as refused:
        moveit.take_scene(message)
    assert reason in str(refused.value)
    assert state(live) == before
    moveit.take_object(box('hand2'))
    assert frozenset(['c', 'hand']) not in short(live), 'the matrix of before counts'


def allowed_by_rule(entry, default_a, default_b):
    """Return what MoveIt's getAllowedCollision says, as a table of its cases."""
    table = {
        (None, None): entry,
        (True, None): True,
        (False, None): False,
        (None, True): True,
        (None, False): False,
        (True, True): True,
        (True, False): False,
        (False, True): False,
        (False, False): False,
    }
    return table[default_a, default_b]


cases = st.tuples(
    st.lists(st.sampled_from(list(combinations(NAMES, 2))), max_size=8),
    st.dictionaries(st.sampled_from(NAMES), st.booleans(), max_size=3),
    st.lists(st.sampled_from(NAMES), unique=True),
)


@settings(max_examples=60, deadline=None)
@given(cases, cases)
def test_a_matrix_excludes_what_moveit_would_not_check(first, second):
    live = live_scene(ARM, Clock())
    moveit = PlanningSceneInput(live)
    moveit.take_scene(planning_scene([box('a')], [attached_object('base', box('b'))]))
    before = short(live)
    for entries, defaults, names in (first, second):
        said = {*names, *(name for pair in entries for name in pair)}
        if not said:
            continue
        moveit.take_scene(planning_scene(allowed=matrix(sorted(said), entries, defaults)))
        sets = [set(pair) for pair in entries]
        expected = {
            pair
            for pair in before
            for x, y in [sorted(pair)]
            if not (
                _has_name(x, y, said, defaults)
                and allowed_by_rule({x, y} in sets, defaults.get(x), defaults.get(y))
            )
        }
        assert short(live) == expected
    moveit.take_scene(planning_scene(allowed=matrix(['later'])))
    assert short(live) == before


def _has_name(x, y, said, defaults):
    """Return whether a matrix says something of a pair: links of the test are of no robot."""
    known = said | defaults.keys() | {'a', 'b'}
    return x in known and y in known


def test_a_matrix_counts_for_an_object_that_comes_or_is_replaced_later(live, moveit):
    moveit.take_scene(
        planning_scene(allowed=matrix(['a', 'hand', 'b'], [('a', 'hand'), ('b', 'hand')]))
    )
    for _ in range(2):
        moveit.take_object(box('a'))
        assert frozenset(['a', 'hand']) not in short(live)
        assert frozenset(['a', 'finger']) in short(live)
    moveit.take_object(collision_object('a', REMOVE))
    moveit.take_object(box('a'))
    assert frozenset(['a', 'hand']) in short(live), 'its entries went with it, as in MoveIt'
    moveit.take_object(box('b'))
    assert frozenset(['b', 'hand']) not in short(live)


def test_a_default_is_about_every_link_of_a_robot(tmp_path):
    spheres = ''.join(
        f'<link name="{link}"><collision><geometry><sphere radius="0.1"/></geometry></collision>'
        '</link>'
        for link in LINKS
    )
    (tmp_path / 'arm.urdf').write_text(f'<robot name="arm">{spheres}{_joints()}</robot>')
    live = live_scene(f'robots:\n- {{name: arm, urdf: {tmp_path}/arm.urdf}}', Clock())
    moveit = PlanningSceneInput(live)
    before = short(live)
    defaults = matrix(['hand', 'base'], (), {'hand': True})
    moveit.take_scene(planning_scene(allowed=defaults))
    assert short(live) == {pair for pair in before if 'hand' not in pair}


def _joints():
    return ''.join(
        f'<joint name="{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/>'
        '</joint>'
        for parent, child in (('base', 'finger'), ('finger', 'hand'))
    )
