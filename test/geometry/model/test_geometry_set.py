"""GeometrySet: the ways to fill one."""

import pytest

from drake_geom_ros.geometry import FrameId, GeometryId, GeometrySet, SourceId
from drake_geom_ros.geometry.model.geometry_set import members_of

F1, F2, G1, G2 = FrameId(1), FrameId(2), GeometryId(1), GeometryId(2)


@pytest.mark.parametrize(
    ('arguments', 'keywords', 'geometries', 'frames'),
    [
        ((), {}, set(), set()),
        ((G1,), {}, {G1}, set()),
        ((F1,), {}, set(), {F1}),
        (([G1, G2],), {}, {G1, G2}, set()),
        (({F1, F2},), {}, set(), {F1, F2}),
        (([G1, F2, G1],), {}, {G1}, {F2}),
        (([G1], [F1]), {}, {G1}, {F1}),
        ((), {'geometry_ids': [G1], 'frame_ids': [F1]}, {G1}, {F1}),
        ((), {'geometry_id': G2}, {G2}, set()),
        ((), {'frame_id': F2}, set(), {F2}),
    ],
)
def test_the_ways_to_fill_one(arguments, keywords, geometries, frames):
    made = GeometrySet(*arguments, **keywords)
    added = GeometrySet()
    added.Add(*arguments, **keywords)
    for geometry_set in (made, added):
        assert members_of(geometry_set) == (geometries, frames)


@pytest.mark.parametrize(
    ('arguments', 'keywords'),
    [
        (([1],), {}),
        (([G2, SourceId(1)],), {}),
        ((3,), {}),
        ((), {'geometry_ids': [G2, F1]}),
        (([G2], [G1]), {}),
        ((), {'frame_id': G2}),
    ],
)
def test_another_kind_is_refused_and_nothing_is_added(arguments, keywords):
    geometry_set = GeometrySet(G1)
    with pytest.raises(RuntimeError, match=r'GeometrySet: .* must be'):
        geometry_set.Add(*arguments, **keywords)
    assert members_of(geometry_set) == ({G1}, set())


def test_prints_in_order():
    text = repr(GeometrySet([G2, G1, F1]))
    expected = '[<GeometryId value=1>, <GeometryId value=2>]'
    assert text == f'GeometrySet(geometry_ids={expected}, frame_ids=[<FrameId value=1>])'
