"""Markers and detections as the bodies of trackers; messages are plain objects."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest

from drake_geom_ros.geometry import ArgumentError, Box, Capsule, Cylinder, Ellipsoid, Sphere
from drake_geom_ros.live.conversions.tracked_markers import MarkerReader, bodies_of_detections
from drake_geom_ros.math import RigidTransform

CUBE, SPHERE, CYLINDER, LINE_STRIP, TEXT, MESH = 1, 2, 3, 4, 9, 10
DELETE, DELETEALL = 2, 3


def pose(p=(0.0, 0.0, 0.0), q=(0.0, 0.0, 0.0, 1.0)):
    return Plain(
        position=Plain(**dict(zip('xyz', p, strict=True))),
        orientation=Plain(**dict(zip('xyzw', q, strict=True))),
    )


def vector(*xyz):
    return Plain(**dict(zip('xyz', xyz, strict=True)))


def marker(kind=SPHERE, id=0, scale=(0.2, 0.2, 0.2), action=0, stamp=5, frame='map', **fields):
    values = {
        'header': Plain(stamp=Plain(sec=stamp, nanosec=0), frame_id=frame),
        'ns': 'people',
        'id': id,
        'type': kind,
        'action': action,
        'pose': pose(),
        'scale': vector(*scale),
        'points': [],
        'lifetime': Plain(sec=0, nanosec=0),
    }
    return Plain(**{**values, **fields})


def read(*markers, reader=None):
    return (reader or MarkerReader()).read(Plain(markers=list(markers)))


@pytest.mark.parametrize(
    ('message', 'shape'),
    [
        (marker(CUBE, scale=(0.1, 0.2, 0.3)), Box(0.1, 0.2, 0.3)),
        (marker(SPHERE), Sphere(0.1)),
        (marker(SPHERE, scale=(0.2, 0.4, 0.6)), Ellipsoid(0.1, 0.2, 0.3)),
        (marker(CYLINDER, scale=(0.2, 0.2, 0.6)), Cylinder(0.1, 0.6)),
    ],
)
def test_a_marker_is_a_body_of_its_size(message, shape):
    bodies = read(message)
    assert (bodies.names, bodies.shapes) == (('people/0',), (shape,))
    assert bodies.lifetimes == (math.inf,), 'a lifetime of 0 is for good'
    np.testing.assert_array_equal(bodies.poses, [[0, 0, 0, 0, 0, 0, 1]])


def test_a_line_is_a_capsule_around_it():
    X_WM = RigidTransform.FromArray([1.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.8])
    ends = np.array([[0.1, 0.2, 0.0], [0.1, 1.2, 0.7], [0.1, 1.2, 0.7], [0.0, 0.0, -3.0]])
    line = marker(
        LINE_STRIP,
        scale=(0.3, 0.0, 0.0),
        points=[vector(*end) for end in ends.tolist()],
        pose=pose(X_WM.translation(), X_WM.ToArray()[3:]),
    )
    bodies = read(line)
    assert bodies.names == ('people/0/0', 'people/0/1', 'people/0/2')
    for k, (shape, row) in enumerate(zip(bodies.shapes, bodies.poses, strict=True)):
        half = 0.5 * (shape.length() if isinstance(shape, Capsule) else 0.0)
        X_WB = RigidTransform.FromArray(row)
        assert shape.radius() == 0.15
        for sign, end in ((-1, ends[k]), (1, ends[k + 1])):
            at = X_WB.multiply([0.0, 0.0, sign * half])
            np.testing.assert_allclose(at, X_WM.multiply(end), rtol=0, atol=1e-12)
    assert isinstance(bodies.shapes[1], Sphere), 'a segment without a length'


def test_markers_are_added_changed_and_deleted():
    reader = MarkerReader()
    assert read(marker(id=0), marker(id=1), reader=reader).gone == frozenset()
    bodies = read(marker(id=2), marker(id=1, action=DELETE), reader=reader)
    assert (bodies.names, bodies.gone) == (('people/2',), {'people/1'})
    bodies = read(marker(action=DELETEALL), marker(id=3), reader=reader)
    assert (bodies.names, bodies.gone) == (('people/3',), {'people/0', 'people/2'})
    points = [vector(0.0, 0.0, float(k)) for k in range(3)]
    bodies = read(marker(LINE_STRIP, id=3, points=points), reader=reader)
    assert bodies.gone == {'people/3'}, 'it has two segments now'
    bodies = read(marker(LINE_STRIP, id=3, points=points[:2]), reader=reader)
    assert bodies.names == ('people/3',)
    assert bodies.gone == {'people/3/0', 'people/3/1'}
    assert read(marker(id=3, action=DELETE), reader=reader).gone == {'people/3'}
    assert read(marker(id=3, action=DELETE), reader=reader).gone == frozenset()


def test_a_marker_lives_for_its_lifetime_and_the_oldest_stamp_counts():
    lifetime = Plain(sec=1, nanosec=500_000_000)
    bodies = read(marker(id=0, lifetime=lifetime, stamp=7), marker(id=1, stamp=6))
    assert bodies.lifetimes == (1.5, math.inf)
    assert bodies.header.stamp.sec == 6


def test_no_marker_says_that_the_tracker_is_well():
    bodies = read()
    assert (bodies.names, bodies.header.stamp.sec, bodies.header.frame_id) == ((), 0, '')


def test_a_turn_that_nobody_filled_is_none_and_labels_are_no_bodies():
    bodies = read(marker(pose=pose(q=(0.0, 0.0, 0.0, 0.0))), marker(TEXT, id=5))
    assert bodies.names == ('people/0',)
    np.testing.assert_array_equal(bodies.poses, [[0, 0, 0, 0, 0, 0, 1]])


@pytest.mark.parametrize(
    ('markers', 'reason'),
    [
        ([marker(MESH)], 'has the type 10; a body is a CUBE'),
        ([marker(action=7)], 'has the action 7'),
        ([marker(CYLINDER, scale=(0.1, 0.2, 1.0))], 'the diameters 0.1 and 0.2'),
        ([marker(LINE_STRIP, points=[vector(0.0, 0.0, 0.0)])], 'is a LINE_STRIP of 1 points'),
        ([marker(scale=(0.0, 0.0, 0.0))], "the body 'people/0'"),
        ([marker(), marker(id=1, frame='odom')], "in the frames 'map' and 'odom'"),
        ([marker(pose=pose(q=(0.0, 0.0, 0.0, 3.0)))], ''),
    ],
)
def test_a_bad_marker_refuses_the_message_and_changes_nothing(markers, reason):
    reader = MarkerReader()
    read(marker(id=9), reader=reader)
    with pytest.raises(RuntimeError) as caught:
        read(*markers, reader=reader)
    assert reason in str(caught.value)
    assert read(marker(action=DELETEALL), reader=reader).gone == {'people/9'}


def detections(*boxes):
    return Plain(
        header='header',
        detections=[
            Plain(id=name, bbox=Plain(center=pose(p), size=vector(*size)))
            for name, p, size in boxes
        ],
    )


def test_a_detection_is_a_box_by_its_id():
    bodies = bodies_of_detections(detections(('7', (1.0, 2.0, 3.0), (0.5, 0.6, 1.7))), 0.8)
    assert bodies.names == ('7',)
    assert bodies.shapes == (Box(0.5, 0.6, 1.7),)
    assert bodies.lifetimes == (0.8,)
    np.testing.assert_array_equal(bodies.poses, [[1, 2, 3, 0, 0, 0, 1]])
    assert bodies_of_detections(detections(), 0.8).poses.shape == (0, 7)


@pytest.mark.parametrize(
    ('boxes', 'reason'),
    [
        ([('', (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))], r'detections\[0\].id is empty'),
        ([('1', (0.0, 0.0, 0.0), (1.0, 0.0, 1.0))], "the body '1'"),
        ([('1', (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))] * 2, 'named twice'),
    ],
)
def test_a_detection_without_id_or_size_is_refused(boxes, reason):
    with pytest.raises(ArgumentError, match=reason):
        bodies_of_detections(detections(*boxes), 1.0)
