"""Depth images to points: encodings, byte orders, steps, and what lies."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.live.conversions.depth_image import points_from_depth

FOCAL = 50.0


def camera(width, height, **changes):
    centre = [(width - 1) / 2, (height - 1) / 2]
    K = [FOCAL, 0.0, centre[0], 0.0, FOCAL, centre[1], 0.0, 0.0, 1.0]
    P = [FOCAL, 0.0, centre[0], 0.0, 0.0, FOCAL, centre[1], 0.0, 0.0, 0.0, 1.0, 0.0]
    roi = Plain(x_offset=0, y_offset=0, width=0, height=0)
    told = {'k': K, 'p': P, 'd': [], 'roi': roi, 'binning_x': 0, 'binning_y': 0}
    return Plain(width=width, height=height, **{**told, **changes})


def image(depths, encoding='32FC1', order='<', gap=0):
    kind, scale = {'32FC1': ('f4', 1.0), '16UC1': ('u2', 1e3)}[encoding]
    rows = (np.asarray(depths, dtype=np.float64) * scale).astype(order + kind)
    data = b''.join(row.tobytes() + b'\xff' * gap for row in rows)
    height, width = rows.shape
    step = width * rows.itemsize + gap
    return Plain(
        width=width, height=height, encoding=encoding, is_bigendian=order == '>', step=step,
        data=bytearray(data),
    )  # fmt: skip


@given(
    st.integers(1, 5), st.integers(1, 5), st.sampled_from(['32FC1', '16UC1']),
    st.sampled_from('<>'), st.integers(0, 5), st.integers(0, 1000),
)  # fmt: skip
def test_every_pixel_is_where_its_ray_has_that_depth(height, width, encoding, order, gap, seed):
    depths = np.random.default_rng(seed).uniform(0.1, 5.0, (height, width)).round(3)
    points = points_from_depth(image(depths, encoding, order, gap), camera(width, height))
    assert points.shape == (height * width, 3)
    assert points[:, 2] == pytest.approx(depths.ravel(), abs=1e-3)
    # Projected as every image pipeline of ROS does it.
    info = camera(width, height)
    u = points[:, 0] / points[:, 2] * info.k[0] + info.k[2]
    v = points[:, 1] / points[:, 2] * info.k[4] + info.k[5]
    rows, columns = np.indices((height, width)).reshape(2, -1)
    assert u == pytest.approx(columns, abs=1e-9)
    assert v == pytest.approx(rows, abs=1e-9)


def test_what_shows_nothing_is_not_finite():
    seen = points_from_depth(image([[0.0, np.nan, np.inf, -1.0, 2.0]]), camera(5, 1))
    assert np.isfinite(seen).all(axis=1).tolist() == [False, False, False, False, True]
    assert np.isnan(points_from_depth(image([[0.0]], '16UC1'), camera(1, 1))).all()


def lie(**changes):
    told = image(np.ones((2, 3)))
    vars(told).update(changes)
    return told


@pytest.mark.parametrize(
    ('told', 'info', 'reason'),
    [
        (lie(encoding='rgb8'), camera(3, 2), "'rgb8'"),
        (lie(height=2**32 - 1), camera(3, 2**32 - 1), 'do not fit'),
        (lie(step=1), camera(3, 2), 'do not fit'),
        (lie(step=2**32 - 1), camera(3, 2), 'do not fit'),
        (lie(data=bytearray()), camera(3, 2), 'do not fit'),
        (lie(data=bytearray(25)), camera(3, 2), 'holds 25 bytes; 2 rows with step 12 have 24'),
        (lie(height=1), camera(3, 1), 'data holds 24 bytes.* 12'),
        (lie(), camera(4, 2), 'camera_info is of 4 x 2'),
        (lie(), camera(3, 2, binning_x=2), 'binning'),
        (lie(), camera(3, 2, roi=Plain(x_offset=1, y_offset=0, width=0, height=0)), 'region'),
        (lie(), camera(3, 2, p=[0.0] * 12, d=[0.1]), 'not rectified'),
        (lie(), camera(3, 2, p=[0.0] * 12, k=[0.0] * 9), 'are none'),
        (lie(), camera(3, 2, p=[np.nan] * 12), 'are none'),
    ],
)
def test_an_image_that_lies_is_refused(told, info, reason):
    with pytest.raises(ValueError, match=reason):
        points_from_depth(told, info)


def test_a_lens_of_countless_coefficients_is_refused():
    with pytest.raises(ValueError, match='5000 coefficients d of distortion; at most'):
        points_from_depth(image([[1.0]]), camera(1, 1, d=[0.0] * 5000))


def test_without_p_the_matrix_k_counts():
    expected = points_from_depth(lie(), camera(3, 2))
    assert points_from_depth(lie(), camera(3, 2, p=[0.0] * 12, d=[0.0] * 5)).tolist() == (
        expected.tolist()
    )
