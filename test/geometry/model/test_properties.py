"""Properties: groups, types, copies, and the read-only ones of a scene."""

import copy

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    GeometryProperties,
    IllustrationProperties,
    MakePhongIllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Rgba,
    Role,
    RoleAssign,
)
from drake_geom_ros.geometry.model.properties import frozen as frozen_copy

KINDS = [ProximityProperties, IllustrationProperties, PerceptionProperties]
names = st.sampled_from(['a', 'b', 'c'])


def test_the_default_group_is_always_there():
    properties = ProximityProperties()
    group = ProximityProperties.default_group_name()
    assert str(properties) == '[__default__]'
    assert properties.GetGroupNames() == {group}
    assert properties.num_groups() == 1
    assert properties.HasGroup(group)
    assert properties.GetPropertiesInGroup(group) == {}


def test_adding_and_reading():
    properties = ProximityProperties()
    properties.AddProperty('material', 'friction', 0.5)
    assert properties.HasProperty('material', 'friction')
    assert not properties.HasProperty('material', 'Friction')
    assert not properties.HasProperty('no', 'friction')
    assert properties.GetProperty('material', 'friction') == 0.5
    assert properties.GetPropertyOrDefault('material', 'friction', 1.0) == 0.5
    assert properties.GetPropertyOrDefault('material', 'friction', None) == 0.5
    assert properties.GetPropertyOrDefault('material', 'mass', 3) == 3
    assert properties.GetPropertyOrDefault('no', 'mass', 'x') == 'x'
    assert properties.GetPropertiesInGroup('material')['friction'].get_value() == 0.5
    assert str(properties) == '[__default__]\n[material]\n  friction: 0.5'


@pytest.mark.parametrize(
    ('call', 'words'),
    [
        (lambda p: p.AddProperty('g', 'n', 2), 'AddProperty.*exists already'),
        (lambda p: p.UpdateProperty('g', 'n', 2.0), 'is of type int, given float'),
        (lambda p: p.UpdateProperty('g', 'n', True), 'is of type int, given bool'),
        (lambda p: p.GetPropertyOrDefault('g', 'n', 2.0), 'is of type int, given float'),
        (lambda p: p.GetProperty('g', 'm'), r"\('g', 'm'\); names \['n'\] exist"),
        (lambda p: p.GetProperty('h', 'n'), r"groups \['__default__', 'g'\] exist"),
        (lambda p: p.GetPropertiesInGroup('h'), "no group 'h'"),
        (lambda p: p.AddProperty('g', 3, 2), 'names must be str'),
        (lambda p: p.AddProperty(3, 'n', 2), 'names must be str'),
    ],
)
def test_refusals_change_nothing(call, words):
    properties = ProximityProperties()
    properties.AddProperty('g', 'n', 1)
    before = str(properties)
    with pytest.raises(RuntimeError, match=words):
        call(properties)
    assert str(properties) == before


def test_updates_and_removal():
    properties = ProximityProperties()
    properties.UpdateProperty('g', 'n', 1)
    properties.UpdateProperty('g', 'n', 2)
    assert properties.GetProperty('g', 'n') == 2
    assert properties.RemoveProperty('g', 'n')
    assert not properties.RemoveProperty('g', 'n')
    assert not properties.RemoveProperty('h', 'n')
    assert properties.HasGroup('g')
    properties.AddProperty('g', 'n', 'another type, for it is another property')


def test_values_are_copied_in_and_out():
    array, items = np.arange(3.0), [1, 2]
    properties = ProximityProperties()
    properties.AddProperty('g', 'array', array)
    properties.AddProperty('g', 'items', items)
    array[0] = items[0] = 99
    properties.GetProperty('g', 'array')[1] = 99
    properties.GetPropertiesInGroup('g')['items'].get_mutable_value().append(99)
    properties.GetPropertiesInGroup('g')['new'] = 99
    assert properties.GetProperty('g', 'array').tolist() == [0, 1, 2]
    assert properties.GetPropertiesInGroup('g').keys() == {'array', 'items'}
    assert properties.GetProperty('g', 'items') == [1, 2]


def test_numpys_numbers_become_pythons():
    properties = ProximityProperties()
    properties.AddProperty('g', 'n', np.float64(0.5))
    assert type(properties.GetProperty('g', 'n')) is float
    properties.UpdateProperty('g', 'n', 0.25)


@pytest.mark.parametrize('kind', KINDS)
def test_copies_are_apart_and_equal(kind):
    original = kind()
    original.AddProperty('g', 'array', np.arange(3))
    original.AddProperty('g', 'pair', (1, [np.ones(2)]))
    for other in (kind(original), copy.copy(original), copy.deepcopy(original)):
        assert other == original
        other.AddProperty('g', 'more', 1)
        assert other != original
        assert not original.HasProperty('g', 'more')
    for wrong in (np.arange(4), np.arange(3.0)):
        other = kind()
        other.AddProperty('g', 'array', wrong)
        other.AddProperty('g', 'pair', (1, [np.ones(2)]))
        assert other != original


def test_kinds_do_not_mix():
    assert ProximityProperties() != IllustrationProperties()
    with pytest.raises(RuntimeError, match='cannot copy'):
        ProximityProperties({'material': {}})
    with pytest.raises(RuntimeError, match='those of a role'):
        GeometryProperties()


def test_those_of_a_role_are_made_of_those_of_another():
    perception = PerceptionProperties()
    perception.AddProperty('renderer', 'accepting', {'vtk', 'gl'})
    illustration = IllustrationProperties(perception)
    proximity = ProximityProperties(other=illustration)
    perception.UpdateProperty('renderer', 'accepting', {'none'})
    assert proximity.GetProperty('renderer', 'accepting') == {'vtk', 'gl'}
    assert type(proximity) is ProximityProperties


def test_frozen_ones_cannot_be_changed_but_their_copies_can():
    original = ProximityProperties()
    original.AddProperty('g', 'n', 1)
    frozen = frozen_copy(original)
    original.UpdateProperty('g', 'n', 2)
    for change in (
        lambda: frozen.AddProperty('g', 'm', 1),
        lambda: frozen.UpdateProperty('g', 'n', 3),
        lambda: frozen.RemoveProperty('g', 'n'),
    ):
        with pytest.raises(RuntimeError, match='kReplace'):
            change()
    assert frozen.GetProperty('g', 'n') == 1
    ProximityProperties(frozen).UpdateProperty('g', 'n', 3)


@given(st.lists(st.tuples(st.sampled_from(['set', 'remove']), names, names, st.integers())))
def test_behaves_as_a_dictionary_of_dictionaries(steps):
    properties, reference = ProximityProperties(), {}
    for action, group, name, value in steps:
        if action == 'set':
            properties.UpdateProperty(group, name, value)
            reference.setdefault(group, {})[name] = value
        else:
            removed = reference.get(group, {}).pop(name, None) is not None
            assert properties.RemoveProperty(group, name) == removed
    assert properties.GetGroupNames() == {'__default__', *reference}
    for group, values in reference.items():
        read = properties.GetPropertiesInGroup(group)
        assert {name: box.get_value() for name, box in read.items()} == values


def test_phong():
    properties = MakePhongIllustrationProperties([1, 0, 0, 0.5])
    assert properties.GetProperty('phong', 'diffuse') == Rgba(1, 0, 0, 0.5)
    for bad, words in (([1, 0, 0], 'must be r, g, b, a'), ([1, 0, 0, 2], r'\[0, 1\]')):
        with pytest.raises(RuntimeError, match=words):
            MakePhongIllustrationProperties(bad)


def test_roles_have_pydrakes_numbers_and_prints():
    assert [int(role) for role in Role] == [0, 1, 2, 4]
    assert Role(4) is Role.kPerception
    assert str(Role.kProximity) == 'Role.kProximity'
    assert repr(RoleAssign.kReplace) == '<RoleAssign.kReplace: 1>'
    assert Role.kIllustration.name == 'kIllustration'
