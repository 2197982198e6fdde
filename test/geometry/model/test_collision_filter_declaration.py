import pytest

from drake_geom_ros.geometry.ids import FrameId, GeometryId
from drake_geom_ros.geometry.model.collision_filter_declaration import (
    CollisionFilterDeclaration,
    CollisionFilterScope,
    SetSnapshot,
)
from drake_geom_ros.geometry.model.geometry_set import GeometrySet


def test_methods_chain_and_keep_the_order():
    a, b = GeometrySet(GeometryId(1)), GeometrySet(FrameId(2))
    declaration = CollisionFilterDeclaration(CollisionFilterScope.kOmitDeformable)
    returned = (
        declaration.ExcludeWithin(geometry_set=a)
        .AllowBetween(set_A=a, set_B=b)
        .ExcludeBetween(b, a)
        .AllowWithin(b)
    )
    assert returned is declaration
    A, B = SetSnapshot((1,), ()), SetSnapshot((), (FrameId(2),))
    assert declaration._statements == [(1, A, A), (4, A, B), (2, B, A), (3, B, B)]


def test_sets_are_copied():
    members = GeometrySet(GeometryId(1))
    declaration = CollisionFilterDeclaration().ExcludeWithin(members)
    members.Add(GeometryId(2))
    assert declaration._statements[0][1].geometries == (1,)


@pytest.mark.parametrize(
    'wrong',
    [
        lambda: CollisionFilterDeclaration('kAll'),
        lambda: CollisionFilterDeclaration().ExcludeWithin([GeometryId(1)]),
        lambda: CollisionFilterDeclaration().AllowBetween(GeometrySet(), GeometryId(1)),
    ],
)
def test_other_types_are_refused(wrong):
    with pytest.raises(RuntimeError, match='must be of type'):
        wrong()


def test_a_refused_statement_leaves_the_declaration_as_it_was():
    declaration = CollisionFilterDeclaration()
    with pytest.raises(RuntimeError, match='set_B'):
        declaration.ExcludeBetween(GeometrySet(), None)
    assert declaration._statements == []
