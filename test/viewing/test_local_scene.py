"""What the page is told equals what the core answers, whatever was moved and filtered."""

import numpy as np
import pytest
from viewing.scenes import local_scene

from drake_geom_ros.geometry import FramePoseVector, QueryObject
from drake_geom_ros.math import RigidTransform

TEXT = """
sources: [s, t]
frames:
  - {name: a, source: s, pose: {position: [1, 0, 0], rpy: [0.3, 0.2, 0.1]}}
  - {name: b, source: s, parent: a, pose: {position: [0, 1, 0]}}
  - {name: c, source: t}
geometries:
  - {name: floor, source: s, shape: {type: half_space}, pose: {position: [0, 0, -1]}}
  - {name: ball, source: s, frame: a, pose: {position: [0, 0, 0.5]},
     shape: {type: sphere, radius: 0.1}}
  - {name: pen, source: s, frame: b, shape: {type: capsule, radius: 0.1, length: 0.4}}
  - {name: seen, source: s, frame: b, shape: {type: box, size: [1, 2, 3]},
     roles: {illustration: {}}}
  - {name: lost, source: t, frame: c, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture
def shown():
    return local_scene(TEXT)


def value(shown, name):
    return next(
        v for v, each in shown.moment(0.0, 'exact').geometries.names.items() if each == name
    )


def pairs_of(shown, reach=10.0):
    pairs = shown.moment(reach, 'exact').pairs
    return {tuple(ids) for ids in pairs.ids.tolist()}


def test_everything_that_has_a_place_stands_there(shown):
    moment = shown.moment(1.0, 'exact')
    query = QueryObject(shown.snapshot())
    assert moment.geometries.waiting == ['c']
    assert [moment.geometries.names[v] for v in moment.geometries.ids.tolist()] == [
        *('s::world/floor', 's::a/ball', 's::b/pen', 's::b/seen')
    ]
    for look in moment.geometries.looks:
        row = moment.geometries.row_of(look.geometry.get_value())
        X_WG = query.X_WG(look.geometry)
        np.testing.assert_allclose(moment.R_WGs[row], X_WG.rotation().matrix(), rtol=0, atol=1e-15)
        np.testing.assert_allclose(moment.p_WGs[row], X_WG.translation(), rtol=0, atol=1e-15)


def test_pairs_are_those_of_the_core_nearest_first(shown):
    pairs = shown.moment(10.0, 'exact').pairs
    found = QueryObject(shown.snapshot()).ComputeSignedDistancePairwiseClosestPoints(10.0)
    assert len(pairs) == len(found) == 3
    assert pairs.distance.tolist() == sorted(found.distance.tolist())
    for row, (a, b) in enumerate(pairs.ids.tolist()):
        (record,) = [f for f in found if (f.id_A.get_value(), f.id_B.get_value()) == (a, b)]
        assert pairs.distance[row] == record.distance
        assert pairs.error_bound[row] == record.error_bound
        gap = pairs.p_WCas[row] - pairs.p_WCbs[row]
        np.testing.assert_allclose(
            gap, record.distance * pairs.nhat_BA_Ws[row], rtol=0, atol=1e-12
        )


def test_the_cast_is_the_same_object_until_somebody_gets_a_place(shown):
    before = shown.moment(1.0, 'exact').geometries
    shown.place(('s', 'a'), RigidTransform([2.0, 0.0, 0.0]))
    assert shown.moment(1.0, 'exact').geometries is before
    shown.pose(FramePoseVector({shown.frames['t', 'c']: RigidTransform()}))
    after = shown.moment(1.0, 'exact').geometries
    assert after.waiting == []
    assert len(after.ids) == len(before.ids) + 1


def test_a_frame_is_placed_in_the_world_whatever_it_hangs_on(shown):
    X_WB = RigidTransform([3.0, 2.0, 1.0])
    shown.place(('s', 'b'), X_WB)
    assert shown.X_WF(('s', 'b')).IsNearlyEqualTo(X_WB, 1e-14)
    assert not shown.poses()['s', 'b'].IsNearlyEqualTo(X_WB, 1e-2)


def test_every_change_is_told(shown):
    seen = [shown.version()]
    ball, pen = value(shown, 's::a/ball'), value(shown, 's::b/pen')
    for change in (
        lambda: shown.place(('s', 'a'), RigidTransform()),
        lambda: shown.exclude((ball, pen)),
        lambda: shown.switch(0, on=False),
    ):
        change()
        assert shown.version() not in seen
        seen.append(shown.version())


def test_declarations_are_switched_off_and_on_in_their_place(shown):
    pair = tuple(sorted((value(shown, 's::a/ball'), value(shown, 's::b/pen'))))
    assert pair in pairs_of(shown)
    shown.exclude(pair)
    shown.allow(pair)
    shown.exclude(pair)
    assert pair not in pairs_of(shown)
    assert any(reason.startswith('transient') for reason in shown.explain(pair))
    shown.switch(2, on=False)
    assert pair in pairs_of(shown)
    # The first one comes back behind the second only if the order is lost.
    shown.switch(0, on=False)
    shown.switch(0, on=True)
    assert pair in pairs_of(shown)
    assert shown.explain(pair) == []
    shown.switch(1, on=False)
    assert pair not in pairs_of(shown)
    assert [each.filter_id is not None for each in shown.history()] == [True, False, False]


def test_a_pair_that_has_no_filters_is_refused_in_words(shown):
    with pytest.raises(RuntimeError, match='seen'):
        shown.explain((value(shown, 's::a/ball'), value(shown, 's::b/seen')))
    with pytest.raises(RuntimeError):
        shown.explain((1, 2))
