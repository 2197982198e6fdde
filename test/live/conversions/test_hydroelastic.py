"""Hydroelastic properties in messages: said in words and numbers, and told so again."""

from types import SimpleNamespace

import pytest

from drake_geom_ros.geometry import (
    AddCompliantHydroelasticProperties,
    ArgumentError,
    HydroelasticType,
    ProximityProperties,
)
from drake_geom_ros.live.conversions.scene import _fill_value, properties_from_message

TEXT, DOUBLE, INTEGER = (4, 'string_value'), (3, 'double_value'), (2, 'integer_value')


def role(number=1, **values):
    kinds = {str: TEXT, float: DOUBLE, int: INTEGER}
    entries = []
    for name, value in values.items():
        kind, field = kinds[type(value)]
        said = SimpleNamespace(type=kind, **{field: value})
        entries.append(SimpleNamespace(group='hydroelastic', name=name, value=said))
    return SimpleNamespace(role=number, properties=entries)


def test_a_message_says_what_drakes_function_says():
    said = properties_from_message(
        role(compliance_type='compliant', resolution_hint=0.01, hydroelastic_modulus=1_000_000)
    )
    expected = ProximityProperties()
    AddCompliantHydroelasticProperties(0.01, 1e6, expected)
    assert said == expected


@pytest.mark.parametrize(
    ('values', 'told'),
    [
        ({'compliance_type': 'soft'}, 'must be one of rigid, compliant, undefined'),
        ({'compliance_type': 1}, 'must be one of'),
        ({'modulus': 1e6}, 'no property .hydroelastic/modulus.; known are compliance_type, '),
        ({'resolution_hint': -0.1}, 'is -0.1; it must be a number > 0'),
        ({'hydroelastic_modulus': '1e6'}, "is '1e6'; it must be a number > 0"),
    ],
)
def test_what_cannot_be_is_refused(values, told):
    with pytest.raises(ArgumentError, match=told):
        properties_from_message(role(**values))


def test_the_group_is_free_for_other_roles():
    said = properties_from_message(role(2, anything='at all'))
    assert said.GetProperty('hydroelastic', 'anything') == 'at all'


@pytest.mark.parametrize('kind', HydroelasticType)
def test_a_scene_message_tells_the_word_that_is_taken_again(kind):
    message = SimpleNamespace(type=0, string_value='')
    _fill_value(message, kind)
    assert message.type == TEXT[0]
    said = properties_from_message(role(compliance_type=message.string_value))
    assert said.GetProperty('hydroelastic', 'compliance_type') is kind
