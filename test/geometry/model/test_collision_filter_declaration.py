import pytest

from drake_geom_ros.geometry import FilterOperation
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
    assert declaration._statements == [
        (FilterOperation.EXCLUDE_WITHIN, A, A),
        (FilterOperation.ALLOW_BETWEEN, A, B),
        (FilterOperation.EXCLUDE_BETWEEN, B, A),
        (FilterOperation.ALLOW_WITHIN, B, B),
    ]


@pytest.mark.parametrize('operation', FilterOperation)
def test_an_operation_is_declared_as_by_its_method(operation):
    sets = [GeometrySet(GeometryId(1)), GeometrySet(GeometryId(2))][: 1 + operation.takes_two_sets]
    by_method = getattr(CollisionFilterDeclaration(), operation.value)(*sets)
    declared = CollisionFilterDeclaration().Declare(operation, *sets)
    assert declared._statements == by_method._statements
    assert operation.excludes == operation.value.startswith('Exclude')
    of = {'excludes': operation.excludes, 'takes_two_sets': operation.takes_two_sets}
    assert FilterOperation.of(**of) is operation
    with pytest.raises(RuntimeError, match=f'{operation.value} takes (one set|set_A and set_B)'):
        CollisionFilterDeclaration().Declare(operation, *(sets[:1] * (3 - len(sets))))


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
