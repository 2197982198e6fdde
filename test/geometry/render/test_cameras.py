"""Cameras and labels: values, and what is refused."""

import copy
import math

import pytest

from drake_geom_ros.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    RenderCameraCore,
    RenderLabel,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensors import CameraInfo

CORE = RenderCameraCore('it', CameraInfo(4, 3, 1.0), ClippingRange(0.1, 10.0))


def test_a_camera_says_what_it_was_made_of():
    X_BS = RigidTransform([1, 2, 3])
    core = RenderCameraCore('it', CORE.intrinsics(), CORE.clipping(), X_BS)
    assert core.sensor_pose_in_camera_body().IsExactlyEqualTo(X_BS)
    assert (core.renderer_name(), core.intrinsics()) == ('it', CameraInfo(4, 3, 1.0))
    assert (core.clipping().near(), core.clipping().far()) == (0.1, 10.0)
    depth = DepthRenderCamera(core, DepthRange(0.2, 9.0))
    assert (depth.depth_range().min_depth(), depth.depth_range().max_depth()) == (0.2, 9.0)
    assert depth.core() is core
    colour = ColorRenderCamera(core)
    assert (colour.core(), colour.show_window()) == (core, False)
    assert repr(core.clipping()) == 'ClippingRange(0.1, 10.0)'
    assert core.clipping() == ClippingRange(0.1, 10.0) != DepthRange(0.1, 10.0)


@pytest.mark.parametrize('kind', [ClippingRange, DepthRange])
@pytest.mark.parametrize(
    'values', [(0.0, 1.0), (-1.0, 1.0), (1.0, 1.0), (2.0, 1.0), (math.nan, 1.0), ('a', 1.0)]
)
def test_ranges_that_are_none_are_refused(kind, values):
    with pytest.raises(RuntimeError, match=kind.__name__):
        kind(*values)


@pytest.mark.parametrize(
    'make',
    [
        lambda: DepthRenderCamera(CORE, DepthRange(0.05, 5.0)),
        lambda: DepthRenderCamera(CORE, DepthRange(0.2, 11.0)),
        lambda: ColorRenderCamera(CORE, show_window=True),
        lambda: ColorRenderCamera('it'),
        lambda: RenderCameraCore('it', CORE.intrinsics(), 3.0),
    ],
)
def test_cameras_that_are_none_are_refused(make):
    with pytest.raises(RuntimeError):
        make()


COPIED = [
    CORE.clipping(),
    DepthRange(0.2, 9.0),
    RenderCameraCore('it', CORE.intrinsics(), CORE.clipping(), RigidTransform([1, 2, 3])),
    ColorRenderCamera(CORE),
    DepthRenderCamera(CORE, DepthRange(0.2, 9.0)),
]


@pytest.mark.parametrize('it', COPIED, ids=lambda it: type(it).__name__)
def test_one_of_the_same_class_is_copied(it):
    kind = type(it)
    for made in (kind(it), kind(other=it)):
        assert made is not it
        for name in [name for base in kind.__mro__ for name in getattr(base, '__slots__', ())]:
            theirs, mine = getattr(it, name), getattr(made, name)
            if isinstance(theirs, RigidTransform):
                assert mine.IsExactlyEqualTo(theirs)
            else:
                assert mine == theirs
    for call in (lambda: kind(it, it), lambda: kind(it, other=it), lambda: kind(1.0, other=it)):
        with pytest.raises(RuntimeError, match='nothing beside'):
            call()
    for call in (kind, lambda: kind(1.0), lambda: kind(other=3.0)):
        with pytest.raises(RuntimeError, match=kind.__name__):
            call()


def test_labels_are_numbers_and_four_are_reserved():
    reserved = {
        RenderLabel.kDontCare: 32764,
        RenderLabel.kDoNotRender: 32765,
        RenderLabel.kEmpty: 32766,
        RenderLabel.kUnspecified: 32767,
    }
    assert {label: int(label) for label in reserved} == reserved
    assert all(label.is_reserved() for label in reserved)
    assert RenderLabel.kMaxUnreserved == 32763
    assert RenderLabel() == RenderLabel.kUnspecified
    assert sorted([RenderLabel(3), RenderLabel(0)]) == [RenderLabel(0), RenderLabel(3)]
    assert copy.deepcopy(RenderLabel(3)) == RenderLabel(3) != 3
    assert not RenderLabel(32763).is_reserved()
    assert repr(RenderLabel.kEmpty) == 'RenderLabel(kEmpty)'


@pytest.mark.parametrize('value', [-1, 32764, 32766, 40000, 'a', 1.0])
def test_labels_that_are_reserved_or_outside_are_refused(value):
    with pytest.raises(RuntimeError, match='RenderLabel'):
        RenderLabel(value)
