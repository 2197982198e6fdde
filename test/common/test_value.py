"""Values in boxes."""

import pytest

from drake_geom_ros.common.value import AbstractValue, Value


def test_a_box_holds_a_copy():
    given = [1]
    box = AbstractValue.Make(given)
    given.append(2)
    other = box.Clone()
    other.get_mutable_value().append(3)
    assert (box.get_value(), other.get_value()) == ([1], [1, 3])
    box.SetFrom(other)
    other.set_value([])
    assert box.get_value() == [1, 3]
    assert repr(box) == 'AbstractValue.Make([1, 3])'


def test_the_type_of_a_value_stays():
    with pytest.raises(RuntimeError, match='is of type int, given float'):
        AbstractValue.Make(3).set_value(3.0)
    with pytest.raises(RuntimeError, match='make one with'):
        AbstractValue()


def test_values_of_a_type():
    box = Value[float](2.5)
    assert isinstance(box, AbstractValue)
    assert type(box) is Value[float]
    assert box.get_value() == 2.5
    assert Value[str]().get_value() == ''
    held = [1]
    other = Value[list](held)
    held.append(2)
    assert other.get_value() == [1], 'a copy is kept'
    box.set_value(3.0)
    assert box.Clone().get_value() == 3.0
    with pytest.raises(TypeError, match="'a' is of type str; it must be float"):
        Value[float]('a')
