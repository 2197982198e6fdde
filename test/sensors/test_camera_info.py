"""The intrinsics of cameras."""

import math

import numpy as np
import pytest

from drake_geom_ros.sensors import CameraInfo


def test_a_field_of_view_puts_the_principal_point_where_drake_does():
    info = CameraInfo(640, 480, math.pi / 4)
    assert (info.center_x(), info.center_y()) == (319.5, 239.5)
    assert info.focal_x() == info.focal_y() == pytest.approx(240.0 / math.tan(math.pi / 8))
    assert info.fov_y() == pytest.approx(math.pi / 4)
    assert info.fov_x() == pytest.approx(2 * math.atan(4 / 3 * math.tan(math.pi / 8)))
    assert (info.width(), info.height()) == (640, 480)


def test_numbers_and_a_matrix_say_the_same():
    info = CameraInfo(width=8, height=6, focal_x=5.0, focal_y=4.0, center_x=3.0, center_y=2.0)
    assert info == CameraInfo(8, 6, 5.0, 4.0, 3.0, 2.0)
    assert info == CameraInfo(8, 6, intrinsic_matrix=info.intrinsic_matrix())
    assert info != CameraInfo(8, 6, 1.0)
    assert hash(info) == hash(CameraInfo(8, 6, 5.0, 4.0, 3.0, 2.0))
    assert eval(repr(info), {'CameraInfo': CameraInfo}) == info


@pytest.mark.parametrize(
    'values',
    [
        (0, 3, 1.0),
        (4, -3, 1.0),
        (4.5, 3, 1.0),
        (4, 3, 0.0),
        (4, 3, math.pi),
        (4, 3, math.nan),
        (4, 3, 'wide'),
        (4, 3),
        (4, 3, 1.0, 2.0),
        (4, 3, 0.0, 1.0, 2.0, 1.0),
        (4, 3, 1.0, math.inf, 2.0, 1.0),
        (4, 3, 1.0, 1.0, 5.0, 1.0),
        (4, 3, 1.0, 1.0, 2.0, -1.0),
        (4, 3, np.ones((3, 3))),
        (4, 3, np.eye(2)),
    ],
)
def test_what_is_no_camera_is_refused(values):
    with pytest.raises(RuntimeError, match='CameraInfo'):
        CameraInfo(*values)
