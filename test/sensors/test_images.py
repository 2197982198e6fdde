"""Images: values by row and column."""

import numpy as np
import pytest

from drake_geom_ros.sensors import Image, ImageDepth32F, ImageLabel16I, ImageRgba8U


@pytest.mark.parametrize(
    ('kind', 'channels', 'dtype'),
    [(ImageRgba8U, 4, np.uint8), (ImageDepth32F, 1, np.float32), (ImageLabel16I, 1, np.int16)],
)
def test_an_image_has_rows_columns_and_channels(kind, channels, dtype):
    image = kind(4, 3, 7)
    assert (image.width(), image.height(), image.size()) == (4, 3, 12 * channels)
    assert image.shape == image.data.shape == (3, 4, channels)
    assert image.data.dtype == dtype
    image.at(3, 2)[:] = 5
    assert image.data[2, 3].tolist() == [5] * channels
    assert image.data.sum() == channels * (11 * 7 + 5)
    image.mutable_data[:] = 1
    assert image == kind.of(np.ones((3, 4, channels), dtype))
    assert image != kind(4, 3)
    image.resize(2, 1)
    assert image == kind(width=2, height=1)
    assert kind().size() == 0
    with pytest.raises(ValueError, match='read-only'):
        image.data[0, 0, 0] = 1
    with pytest.raises(RuntimeError, match=r'\(2, 0\)'):
        image.at(2, 0)


def test_what_is_no_image_is_refused():
    for make in (
        lambda: ImageRgba8U(4),
        lambda: ImageRgba8U(-1, 3),
        lambda: ImageDepth32F.of(np.zeros((3, 4), np.float32)),
        lambda: ImageDepth32F.of(np.zeros((3, 4, 1))),
    ):
        with pytest.raises(RuntimeError, match='Image'):
            make()
    with pytest.raises(TypeError):
        Image(4, 3)
