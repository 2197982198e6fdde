"""FramePoses messages with plain objects: no message class, no ROS."""

import math
from types import SimpleNamespace as Plain

import pytest

from drake_geom_ros.geometry import FramePoseVector, GeometryFrame, SceneGraph
from drake_geom_ros.live.conversions.frame_poses import FramePosesReader
from drake_geom_ros.live.conversions.names import NameTable


def plain_poses(names=(), ids=(), rows=(), source='', frame_id=''):
    flat = [float(x) for row in rows for x in row]
    header = Plain(frame_id=frame_id)
    return Plain(
        header=header, source=source, frame_names=list(names), frame_ids=list(ids), poses=flat
    )


def test_frame_poses_by_name_and_by_id(scene, names):
    reader = FramePosesReader(names)
    row = [1, 2, 3, 0, 0, 0, 1]
    left = names.frame('left::arm')
    for message in (
        plain_poses(['left::arm'], rows=[row]),
        plain_poses(['arm'], rows=[row], source='left'),
        plain_poses(['hand'], rows=[row]),
        plain_poses(ids=[left.get_value()], rows=[row]),
        plain_poses(ids=[left.get_value()], rows=[row], source='left'),
    ):
        for _ in range(2):  # The second time the names are known.
            poses, frames, rows = reader.read(message)
            assert rows.tolist() == [row]
            assert isinstance(poses, FramePoseVector)
            assert poses.value(poses.ids()[0]).translation().tolist() == [1, 2, 3]
            assert frames == {poses.ids()[0].get_value()}
            assert reader.read(message).frames is frames
    assert len(reader.read(plain_poses()).poses) == 0


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (plain_poses(['arm'], rows=[[0] * 7]), "2 frames share the name 'arm': 'left::arm'"),
        (plain_poses(['nobody'], rows=[[0] * 7]), "no frame 'nobody'"),
        (plain_poses(['n' * 10**6], rows=[[0] * 7]), r'nnn\.\.\.'),
        (plain_poses(['hand'], rows=[[0] * 7], source='nobody'), "no source 'nobody'"),
        (plain_poses(['hand'], rows=[[0] * 7], source='left'), "no frame 'left::hand'"),
        (plain_poses(['right::hand'], rows=[[0] * 7], source='left'), 'does not belong'),
        (plain_poses(['hand'], rows=[[0] * 6]), '6 numbers for 1 frame;'),
        (plain_poses(rows=[[0] * 7]), '7 numbers for 0 frames'),
        (plain_poses(['hand'], [3], rows=[[0] * 7]), 'both given'),
        (plain_poses(['hand', 'right::hand'], rows=[[0] * 7] * 2), 'named twice'),
        (plain_poses(['world'], rows=[[0] * 7]), 'world frame'),
        (plain_poses(ids=[10**15], rows=[[0] * 7]), '#1000000000000000'),
        (plain_poses(['hand'], rows=[[0, 0, math.inf, 0, 0, 0, 1]]), 'not finite'),
        (plain_poses(['hand'], rows=[[0, 0, 0, 0, 0, 0, 1.01]]), 'norm 1.01'),
        (plain_poses(['hand'], rows=[[0] * 7], frame_id='map'), "frame_id is 'map'; .* 'world'"),
    ],
)
def test_frame_poses_that_are_none_are_refused(names, message, words):
    with pytest.raises(RuntimeError, match=words):
        FramePosesReader(names).read(message)


def test_a_name_is_not_the_id_that_it_spells():
    scene = SceneGraph()
    source = scene.RegisterSource('robot')
    first = scene.RegisterFrame(source, GeometryFrame('first'))
    number = first.get_value()
    second = scene.RegisterFrame(source, GeometryFrame(str(number)))
    reader = FramePosesReader(NameTable(scene.model_inspector()))
    row = [0, 0, 0, 0, 0, 0, 1]
    by_name, by_id = plain_poses([str(number)], rows=[row]), plain_poses(ids=[number], rows=[row])
    for _ in range(2):
        assert reader.read(by_name).poses.ids() == [second]
        assert reader.read(by_id).poses.ids() == [first]


def test_memory_of_names_is_bounded(names):
    reader = FramePosesReader(names)
    hand = names.frame('hand').get_value()
    for k in range(1000):
        with pytest.raises(RuntimeError):
            reader.read(plain_poses(ids=[hand, 10**6 + k], rows=[[0, 0, 0, 0, 0, 0, 1]] * 2))
        reader.read(plain_poses(['right::hand'], rows=[[0, 0, 0, 0, 0, 0, 1]]))
    assert len(reader._known) <= 64


def test_a_source_poses_its_own_frames_whatever_their_names_begin_with():
    scene = SceneGraph()
    frames = {}
    for source, name in (('a', 'b::c'), ('a::b', 'd')):
        frames[source] = scene.RegisterFrame(scene.RegisterSource(source), GeometryFrame(name))
    reader = FramePosesReader(NameTable(scene.model_inspector()))
    row = [1, 2, 3, 0, 0, 0, 1]
    assert reader.read(plain_poses(['b::c'], rows=[row], source='a')).frames == {
        frames['a'].get_value()
    }
    theirs = plain_poses(ids=[frames['a::b'].get_value()], rows=[row], source='a')
    with pytest.raises(RuntimeError, match="'a::b::d' does not belong to source 'a'"):
        reader.read(theirs)
