"""Who asked for a transient filter is told wherever the filter is; without ROS."""

from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import live_scene

from drake_geom_ros.live.scene import scene_model
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.services import filters, queries
from drake_geom_ros.scene_files import read_scene

TEXT = """
sources: [s]
frames: [{name: a, source: s}, {name: b, source: s}]
geometries:
  - {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
"""
EXCLUDE_WITHIN = 1
EMPTY = {'frame_ids': [], 'geometry_ids': []}
BOTH = Plain(frames=['a', 'b'], geometries=[], **EMPTY)
DECLARATION = Plain(
    statements=[
        Plain(operation=EXCLUDE_WITHIN, set_a=BOTH, set_b=Plain(frames=[], geometries=[], **EMPTY))
    ]
)


@pytest.fixture
def live(clock):
    return live_scene(TEXT, clock)


def apply(live, owner, lease=0.0):
    """Apply a transient filter, and return its id."""
    request = Plain(declaration=DECLARATION, owner=owner, lease=lease)
    response = Plain()
    filters.apply_transient_filter(live, request, response)
    return response.filter_id


def state(live):
    """Return the owners by the ids of the active filters, and the reasons of the pair."""
    answer, explained = Plain(), Plain()
    queries.get_filters(live, Plain(), answer)
    pair = Plain(geometry_a='a/ball', geometry_b='b/ball')
    queries.explain_filter(live, pair, explained)
    ids = list(answer.active_filter_ids)
    return dict(zip(ids, answer.active_filter_owners, strict=True)), explained.reasons


def told(live):
    with live.editing() as scene:
        lines, scene.log.notes = scene.log.notes, []
    return lines


def test_owners_stand_beside_the_filters_that_they_asked_for(live):
    planner, nobody = apply(live, 'planner'), apply(live, '')
    owners, reasons = state(live)
    assert owners == {planner: 'planner', nobody: ''}
    # Of declarations about the same sets the newest is named first.
    assert reasons[0] == f'transient declaration {nobody}'
    assert reasons[-1] == f"transient declaration {planner} (owner 'planner')"
    with live.editing() as scene:
        filters.remove_filter(live, Plain(filter_id=planner, owner=''), Plain())
        assert scene.filters.owners() == {nobody: ''}
    assert state(live) == ({nobody: ''}, [f'transient declaration {nobody}'])


def test_what_becomes_of_a_filter_is_told_with_its_owner(live, clock):
    planner, nobody = apply(live, 'planner', 5.0), apply(live, '')
    assert told(live) == [
        f"transient filter {planner} for 5 s (owner 'planner')",
        f'transient filter {nobody} until it is removed',
    ]
    clock.now += 6.0
    with live.editing() as scene:
        scene.filters.expire()
        filters.remove_filter(live, Plain(filter_id=nobody, owner=''), Plain())
        filters.remove_filter(live, Plain(filter_id=nobody, owner=''), Plain())
    assert told(live) == [
        f"the lease of transient filter {planner} expired: removed (owner 'planner')",
        f'transient filter {nobody} removed',
    ]


def test_leases_that_end_together_are_told_in_a_line_for_each_owner(live, clock):
    numbers = [apply(live, 'planner', 5.0) for _ in range(7)]
    other = apply(live, '', 5.0)
    told(live)
    clock.now += 6.0
    with live.editing() as scene:
        assert len(scene.filters.expire()) == 8
    some = ', '.join(map(str, numbers[:5]))
    assert told(live) == [
        f"the lease of 7 transient filters ({some} ...) expired: removed (owner 'planner')",
        f'the lease of transient filter {other} expired: removed',
    ]


def test_an_owner_has_no_more_filters_than_one_may_have(live, clock):
    with live.editing() as scene:
        scene.filters.most_per_owner = 2
    ids = [apply(live, 'planner', 5.0), apply(live, 'planner')]
    with pytest.raises(RuntimeError, match=r"owner 'planner' has 2 .* filters_per_owner"):
        apply(live, 'planner')
    others = [apply(live, ''), apply(live, '')]
    with pytest.raises(RuntimeError, match="owner '' has 2"):
        apply(live, '', 1.0)
    assert sorted(state(live)[0]) == ids + others
    # A lease that ended, and a filter that was removed, make room.
    clock.now += 6.0
    with live.editing() as scene:
        scene.filters.expire()
        filters.remove_filter(live, Plain(filter_id=others[0], owner=''), Plain())
    for owner in ('planner', ''):
        apply(live, owner)
        with pytest.raises(RuntimeError, match='has 2'):
            apply(live, owner)


def test_who_is_gone_is_forgotten(live):
    for number in range(5):
        apply(live, f'owner {number}')
    filters.flatten_filters(live, Plain(), Plain())
    assert state(live)[0] == {}
    with live.editing() as scene:
        assert scene.filters._owners == {}


@pytest.mark.parametrize(
    ('owner', 'may'), [('planner', True), ('', True), ('other', False), ('planne', False)]
)
def test_who_says_who_asks_reaches_its_own_filters_only(live, clock, owner, may):
    number = apply(live, 'planner', 5.0)
    renewed, removed = Plain(), Plain()
    request = Plain(filter_id=number, lease=50.0, owner=owner)
    filters.renew_filter(live, request, renewed)
    clock.now += 6.0
    with live.editing() as scene:
        assert bool(scene.filters.expire()) is not may
    again = apply(live, 'planner', 5.0)
    filters.remove_filter(live, Plain(filter_id=again, owner=owner), removed)
    assert (renewed.active, removed.removed) == (may, may)
    assert (again in state(live)[0]) is not may
    clock.now += 6.0
    with live.editing() as scene:  # the lease of one that was not removed still ends
        scene.filters.expire()
    assert again not in state(live)[0]


@pytest.mark.parametrize('number', [0, 2**60])
def test_a_number_of_nothing_is_not_active(live, number):
    renewed, removed = Plain(), Plain()
    filters.renew_filter(live, Plain(filter_id=number, lease=1.0, owner='a'), renewed)
    filters.remove_filter(live, Plain(filter_id=number, owner='a'), removed)
    assert (renewed.active, removed.removed) == (False, False)


def test_a_frame_that_carries_many_geometries_is_no_short_declaration(clock, monkeypatch):
    """It is one name, and takes as long as the names of all of them would."""
    monkeypatch.setattr(scene_model, '_MANY', 0)  # any scene is large
    monkeypatch.setattr(filters, '_MANY', 4)
    live = live_scene(TEXT, clock)
    drafts, make_ready = [], live.make_ready
    monkeypatch.setattr(live, 'make_ready', lambda change: drafts.append(1) or make_ready(change))
    apply(live, 'about two geometries')
    assert drafts == []
    shape = 'shape: {type: sphere, radius: 0.1}'
    more = ''.join(f'- {{name: g{k}, source: t, frame: c, {shape}}}\n' for k in range(4))
    with live.editing() as scene:
        scene.make(addition(read_scene('frames: [{name: c, source: t}]\ngeometries:\n' + more)))
        frame = scene.model.names.frame('t::c').get_value()
    nobody = Plain(frames=[], geometries=[], **EMPTY)
    by_id = Plain(**{**vars(nobody), 'frame_ids': [frame]})
    for count, members in enumerate((Plain(**{**vars(nobody), 'frames': ['t::c']}), by_id), 1):
        statement = Plain(operation=EXCLUDE_WITHIN, set_a=members, set_b=nobody)
        declaration = Plain(statements=[statement])
        request = Plain(declaration=declaration, owner='', lease=0.0)
        filters.apply_transient_filter(live, request, Plain())
        assert len(drafts) == count
