"""PointCloud2 in all its layouts."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.live.conversions.point_cloud import points_from_cloud


def cloud(points, *, kind='f4', before=0, between=0, height=1, row_gap=0, order='<'):
    """Return a PointCloud2 of points (n, 3), x last, with gaps of so many bytes."""
    names = ['z', 'y', 'x']
    size = np.dtype(kind).itemsize
    offsets = [before + k * (size + between) for k in range(3)]
    step = offsets[-1] + size + between
    dtype = np.dtype(
        {'names': names, 'formats': [order + kind] * 3, 'offsets': offsets, 'itemsize': step}
    )
    width = len(points) // height
    rows = []
    for row in np.reshape(points, (height, width, 3)):
        filled = np.zeros(width, dtype)
        for axis, values in zip('xyz', row.T, strict=True):
            filled[axis] = values
        rows.append(filled.tobytes() + b'\xff' * row_gap)
    fields = [
        Plain(name=name, offset=offset, datatype=7 if kind == 'f4' else 8, count=1)
        for name, offset in zip(names, offsets, strict=True)
    ]
    fields.insert(1, Plain(name='intensity', offset=0, datatype=2, count=1))
    return Plain(
        header=Plain(frame_id='', stamp=None),
        width=width,
        height=height,
        fields=fields,
        is_bigendian=order == '>',
        point_step=step,
        row_step=step * width + row_gap,
        data=bytearray(b''.join(rows)),
        is_dense=False,
    )


@given(
    rows=st.integers(0, 4),
    columns=st.integers(1, 5),
    kind=st.sampled_from(['f4', 'f8']),
    before=st.integers(0, 9),
    between=st.integers(0, 5),
    row_gap=st.integers(0, 7),
    order=st.sampled_from('<>'),
    seed=st.integers(0, 2**31),
)
def test_any_layout_gives_the_points_in_order(
    rows, columns, kind, before, between, row_gap, order, seed
):
    points = np.random.default_rng(seed).normal(size=(rows * columns, 3)).astype(kind)
    if rows:
        points[0, 1] = np.nan
    layout = {'before': before, 'between': between, 'row_gap': row_gap, 'order': order}
    message = cloud(points, kind=kind, height=max(rows, 1), **layout)
    np.testing.assert_array_equal(points_from_cloud(message), points.astype(float))


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'width': 5}, '5 points'),
        ({'height': 2}, '2 rows'),
        ({'point_step': 3}, 'point_step'),
        ({'height': 2, 'row_step': 0}, 'row_step'),
        ({'data': bytearray()}, '0 bytes'),
        ({'fields': []}, 'lacks x, y, z'),
        ({'width': 2**32 - 1, 'height': 2**32 - 1}, 'do not fit'),
        ({'data': bytearray(49)}, 'data holds 49 bytes; 1 rows with row_step 48 have 48'),
        ({'height': 2, 'width': 2, 'row_step': 23}, 'do not fit'),
        ({'height': 2, 'width': 1, 'row_step': 12}, 'data holds 48 bytes.* 24'),
        ({'width': 3, 'row_step': 0}, 'data holds 48 bytes.* 36'),
        ({'height': 0}, 'data holds 48 bytes.* 0;'),
    ],
)
def test_a_cloud_that_lies_about_its_size_is_refused(change, words):
    message = cloud(np.ones((4, 3)))
    vars(message).update(change)
    with pytest.raises(RuntimeError, match=words):
        points_from_cloud(message)


@pytest.mark.parametrize('axis', ['x', 'y', 'z'])
def test_a_coordinate_that_is_there_twice_is_refused_and_padding_is_not(axis):
    message = cloud(np.ones((4, 3)))
    padding = [Plain(name='_', offset=k, datatype=2, count=1) for k in range(2)]
    message.fields += padding
    assert points_from_cloud(message).tolist() == np.ones((4, 3)).tolist()
    message.fields.append(Plain(name=axis, offset=8, datatype=7, count=1))
    with pytest.raises(RuntimeError, match=f'fields has {axis} more than once'):
        points_from_cloud(message)


@pytest.mark.parametrize(('name', 'value'), [('datatype', 5), ('count', 3), ('offset', 10_000)])
def test_a_field_that_is_no_coordinate_is_refused(name, value):
    message = cloud(np.ones((4, 3)))
    setattr(message.fields[-1], name, value)
    with pytest.raises(RuntimeError):
        points_from_cloud(message)
