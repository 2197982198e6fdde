"""Records of numbers with derivatives that nobody filled: those of floats, without derivatives."""

import numpy as np
import pytest

from drake_geom_ros.autodiffutils import AutoDiffXd, ExtractValue
from drake_geom_ros.geometry import (
    PenetrationAsPointPair_,
    SignedDistancePair_,
    SignedDistanceToPoint_,
)


@pytest.mark.parametrize(
    'template', [SignedDistancePair_, PenetrationAsPointPair_, SignedDistanceToPoint_]
)
def test_a_new_record_has_the_fields_of_the_one_of_floats(template):
    plain, record = template[float](), template[AutoDiffXd]()
    names = [name for name in plain.__dataclass_fields__ if not name.startswith('_')]
    assert len(names) > 5
    for name in names:
        value, expected = getattr(record, name), getattr(plain, name)
        if isinstance(value, AutoDiffXd):
            assert value.derivatives().size == 0
            value = value.value()
        elif isinstance(value, np.ndarray):
            value = ExtractValue(value).ravel()
        np.testing.assert_array_equal(value, expected)
