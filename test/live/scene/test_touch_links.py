"""What an attached frame may touch: a filter that detach takes back, without ROS."""

from itertools import combinations
from types import SimpleNamespace as Plain

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.live_scenes import Clock, live_scene
from live.scene.test_changes import attach, call, detach, pose

from drake_geom_ros.geometry import GeometryId, SceneGraph
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.services import filters, scene
from drake_geom_ros.scene_files import (
    SceneFileError,
    load_scene,
    read_scene,
    to_yaml,
    touched_geometries,
)

URDF = """<robot name="arm">
  <link name="base"/>
  <link name="hand"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="left"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <link name="right"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <joint name="wrist" type="continuous"><parent link="base"/><child link="hand"/></joint>
  <joint name="l" type="continuous"><parent link="hand"/><child link="left"/></joint>
  <joint name="r" type="continuous"><parent link="hand"/><child link="right"/></joint>
</robot>
"""
SRDF = """<robot name="arm">
  <group name="fingers"><link name="left"/><joint name="r"/></group>
  <group name="gripper"><chain base_link="base" tip_link="hand"/><group name="fingers"/></group>
</robot>
"""
PARTS = """
sources: [parts]
frames:
- {name: box, source: parts, pose: {}}
- {name: lid, source: parts, parent: box, pose: {}}
- {name: other, source: parts, pose: {}}
geometries:
- {name: box, source: parts, frame: box, shape: {type: sphere, radius: 0.1}}
- {name: lid, source: parts, frame: lid, shape: {type: sphere, radius: 0.1}}
- {name: other, source: parts, frame: other, shape: {type: sphere, radius: 0.1}}
- {name: table, source: parts, shape: {type: box, size: [1, 1, 0.1]}}
"""
CELL = PARTS.replace('sources: [parts]', 'sources: [arm, parts]').replace(
    'geometries:',
    """- {name: hand, source: arm, pose: {}}
- {name: left, source: arm, pose: {}}
- {name: right, source: arm, pose: {}}
geometries:
- {name: hand, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: left, source: arm, frame: left, shape: {type: sphere, radius: 0.1}}
- {name: right, source: arm, frame: right, shape: {type: sphere, radius: 0.1}}""",
)
CARRIED = {'parts::box/box', 'parts::lid/lid'}


def no_pose():
    """Return the response of a call of ``attach``."""
    return Plain(pose=pose(), filter_id=0)


@pytest.fixture
def live(tmp_path):
    (tmp_path / 'arm.urdf').write_text(URDF)
    (tmp_path / 'arm.srdf').write_text(SRDF)
    robot = f'robots: [{{name: arm, urdf: {tmp_path}/arm.urdf, srdf: {tmp_path}/arm.srdf}}]'
    cell = live_scene(f'{robot}{PARTS}', Clock())
    with cell.editing() as held:
        for frame in held.query.waiting_frames():
            held.poses.put({held.model.names.labels[frame]: held.query.X_PF(box(held))})
    return cell


def box(held):
    return held.model.names.frame('box')


def reported(live):
    """Return the pairs that queries report, by names."""
    with live.reading() as held:
        names, candidates = held.model.names, held.model.inspector.candidate_pairs()
        ids = [GeometryId(value) for value in candidates.ids.tolist()]
        return {
            frozenset([names.geometry_names[a], names.geometry_names[b]])
            for a, b in combinations(ids, 2)
            if not held.model.inspector.CollisionFiltered(a, b)
        }


def lost(live, **fields):
    """Attach the box; return the partners that it, and what it carries, lost."""
    before = reported(live)
    answer = attach_box(live, **fields)
    assert answer.success, answer.message
    gone = before - reported(live)
    partners = [set(pair) - CARRIED for pair in gone]
    assert all(len(each) == 1 for each in partners)
    whole = {name for each in partners for name in each}
    assert gone == {frozenset([own, other]) for own in CARRIED for other in whole}
    assert bool(whole) == bool(answer.filter_id)
    return whole


def attach_box(live, **fields):
    request = {'frame': 'box', 'parent': 'hand', 'pose_given': False, 'pose': pose()}
    request |= {'part_of_robot': True, 'touch_links': []}
    return call(live, scene.attach, no_pose(), **{**request, **fields})


@pytest.mark.parametrize(
    ('touch_links', 'touched'),
    [
        ([], []),
        (['hand'], ['hand']),
        (['arm::hand', 'left/*'], ['hand', 'left']),
        (['fingers'], ['left', 'right']),
        (['arm::gripper'], ['hand', 'left', 'right']),
        (['arm'], ['hand', 'left', 'right']),
        (['base'], []),
        (['box', 'lid'], []),
    ],
)
def test_pairs_with_touch_links_are_left_out_until_detach(live, touch_links, touched):
    before = reported(live)
    partners = lost(live, touch_links=touch_links)
    assert {name.partition('/')[0] for name in partners} == {f'arm::{link}' for link in touched}
    assert detach(live, frame='box').success
    assert reported(live) == before


def test_links_are_looked_for_again_where_the_scene_changes_meanwhile(live, monkeypatch):
    looked = []

    def look(*args):
        found = touched_geometries(*args)
        looked.append(found)
        if len(looked) == 1:  # beside the cycles
            gone = {'geometry': 'arm::left/collision_0'}
            assert call(live, scene.remove_geometry, Plain(), **gone).success
        return found

    monkeypatch.setattr(scene, 'touched_geometries', look)
    assert attach_box(live, touch_links=['gripper']).success
    assert [len(each) for each in looked] == [3, 2]


def test_what_the_carrier_holds_besides_is_not_touched(live):
    assert attach_box(live, frame='other').success
    assert not any('other' in name for name in lost(live, touch_links=['hand', 'arm']))


def test_attaching_again_replaces_what_may_be_touched(live):
    before = reported(live)
    lost(live, touch_links=['hand'])
    first = attach_box(live, touch_links=['left']).filter_id
    gone = before - reported(live)
    assert {name for pair in gone for name in pair - CARRIED} == {names_of(live, 'arm::left')}
    assert attach_box(live).filter_id == 0
    assert reported(live) == before
    answer = call(live, filters.remove_filter, Plain(removed=None), filter_id=first, owner='')
    assert answer.removed is False


def names_of(live, frame):
    with live.reading() as held:
        names = held.model.names.geometry_names.values()
    (name,) = (name for name in names if name.startswith(f'{frame}/'))
    return name


@pytest.mark.parametrize(
    ('touch_links', 'reason'),
    [
        (['hnd'], "touch_links: 'hnd' stands for no frame, no geometry and no group"),
        (['left', ''], "touch_links: ''"),
        (['other::fingers'], "touch_links: 'other::fingers'"),
    ],
)
def test_a_link_that_nothing_bears_is_refused_and_nothing_changes(live, touch_links, reason):
    before = reported(live)
    answer = attach_box(live, touch_links=touch_links)
    assert not answer.success
    assert reason in answer.message
    assert reported(live) == before
    with live.reading() as held:
        assert not held.model.attached


def test_a_refused_attachment_leaves_the_one_before(live):
    lost(live, touch_links=['hand'])
    during = reported(live)
    assert not attach_box(live, parent='lid', touch_links=['left']).success
    assert reported(live) == during
    assert detach(live, frame='box').success


def test_the_filter_has_an_owner_and_may_get_a_lease(live):
    before = reported(live)
    number = attach_box(live, touch_links=['hand']).filter_id
    with live.editing() as held:
        assert held.filters.owners() == {number: 'attach parts::box'}
        assert held.filters.leases() == {}
    request = {'filter_id': number, 'owner': '', 'lease': 2.0}
    renewed = call(live, filters.renew_filter, Plain(active=None), **request)
    assert renewed.active
    with live.editing() as held:
        held.clocks.steady.now += 3.0
        assert [each.get_value() for each in held.filters.expire()] == [number]
        assert held.filters.touch_links.names() == {}
        assert held.model.attached, 'the part stays where it is'
    assert reported(live) == before
    assert detach(live, frame='box').success


def test_a_source_that_goes_takes_its_filter_along(live):
    attach_box(live, touch_links=['hand'])
    assert call(live, scene.remove_source, Plain(), source='parts').success
    with live.reading() as held:
        assert not held.model.filter_manager.has_transient_history()
        assert held.filters.owners() == {}


def test_a_group_of_two_robots_needs_its_robot(live, tmp_path):
    (tmp_path / 'b.urdf').write_text(URDF.replace('name="arm"', 'name="b"'))
    (tmp_path / 'b.srdf').write_text(SRDF.replace('name="arm"', 'name="b"'))
    text = f'robots:\n- {{name: b, urdf: {tmp_path}/b.urdf, srdf: {tmp_path}/b.srdf}}'
    with live.editing() as held:
        held.make(addition(read_scene(text)))
    answer = attach_box(live, parent='arm::hand', touch_links=['fingers'])
    assert "is a group of several robots: 'arm::fingers', 'b::fingers'" in answer.message
    assert attach_box(live, parent='arm::hand', touch_links=['b::fingers']).success


HELD = CELL.replace(
    '{name: box, source: parts, pose: {}}',
    '{name: box, source: parts, pose: {}, attached_to: hand, touch_links: [arm, table]}',
)


def saved(live):
    with live.reading() as held:
        return to_yaml(held.snapshot().description())


def box_in(text):
    (frame,) = (each for each in read_scene(text).frames if each.name == 'box')
    return frame


def test_a_scene_file_attaches_as_the_service_does():
    by_call, by_file = live_scene(CELL, Clock()), live_scene(HELD, Clock())
    assert attach_box(by_call, touch_links=['arm', 'table']).success
    assert reported(by_file) == reported(by_call)
    with by_file.reading() as held:
        assert list(held.filters.owners().values()) == ['attach parts::box']
    assert detach(by_file, frame='box').success
    assert reported(by_file) == reported(live_scene(CELL, Clock()))


def test_a_saved_scene_attaches_again():
    first = live_scene(HELD, Clock())
    names = ('arm::hand/hand', 'arm::left/left', 'arm::right/right', 'parts::world/table')
    assert box_in(saved(first)).touch_links == names
    again = live_scene(saved(first), Clock())
    assert reported(again) == reported(first)
    assert saved(again) == saved(first)


def test_what_may_be_touched_for_a_while_alone_is_not_saved():
    cell = live_scene(HELD, Clock())
    with cell.editing() as held:
        (number,) = held.filters.owners()
    request = {'filter_id': number, 'owner': '', 'lease': 2.0}
    assert call(cell, filters.renew_filter, Plain(active=None), **request).active
    assert box_in(saved(cell)).touch_links == ()
    assert box_in(saved(cell)).attached_to is not None


def test_a_geometry_that_went_is_no_longer_touched_in_a_saved_scene():
    cell = live_scene(HELD, Clock())
    assert call(cell, scene.remove_geometry, Plain(), geometry='arm::left/left').success
    assert 'arm::left/left' not in box_in(saved(cell)).touch_links
    assert reported(live_scene(saved(cell), Clock())) == reported(cell)


def test_groups_of_an_srdf_may_be_touched_from_the_start(tmp_path):
    (tmp_path / 'arm.urdf').write_text(URDF)
    (tmp_path / 'arm.srdf').write_text(SRDF)
    robot = f'robots: [{{name: arm, urdf: {tmp_path}/arm.urdf, srdf: {tmp_path}/arm.srdf}}]'
    text = HELD.partition('geometries:')[0].replace('[arm, table]', '[fingers]')
    text = '\n'.join(line for line in text.splitlines() if 'source: arm' not in line)
    geometry = '{name: b, source: parts, frame: box, shape: {type: sphere, radius: 0.1}}'
    loaded = load_scene(f'{robot}\n{text}\ngeometries: [{geometry}]', SceneGraph())
    ((frame, touch_links),) = loaded.touch_links.items()
    assert frame == loaded.frames['parts', 'box']
    assert touch_links.names == ('arm::left/collision_0', 'arm::right/collision_0')


@pytest.mark.parametrize(
    ('before', 'after', 'reason'),
    [
        ('attached_to: hand, ', '', 'touch_links is of frames that are attached'),
        ('[arm, table]', '[hnd]', "'hnd' stands for no frame, no geometry and no group"),
    ],
)
def test_a_scene_file_whose_attachment_makes_no_sense_is_refused(before, after, reason):
    with pytest.raises(SceneFileError, match=reason):
        load_scene(HELD.replace(before, after), SceneGraph())


@settings(max_examples=30, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(['box', 'other']),
            st.sampled_from(['', 'hand', 'left', 'world']),
            st.lists(st.sampled_from(['hand', 'left', 'right', '*', 'parts', 'table'])),
        ),
        max_size=8,
    )
)
def test_after_any_order_detach_leaves_all_pairs_as_they_were(steps):
    cell = live_scene(CELL, Clock())
    before = reported(cell)
    for frame, parent, touch_links in steps:
        if parent:
            attach(cell, frame=frame, parent=parent, touch_links=touch_links)
        else:
            detach(cell, frame=frame)
    for frame in ('box', 'other'):
        detach(cell, frame=frame)
    assert reported(cell) == before
