"""Poses that are copied out are read back to the last digit."""

import pytest
from viewing.scenes import local_scene

from drake_geom_ros.command_line.pose_file import read_poses
from drake_geom_ros.common.frame_names import AmbiguousNameError, full_name
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.viewing.texts import as_csv, as_yaml

TEXT = """
sources: ["s, <b>"]
frames: [{name: 'a: "x"', source: "s, <b>"}, {name: b, source: "s, <b>"}]
"""


@pytest.fixture
def poses():
    shown = local_scene(TEXT)
    a, b = shown.frames
    shown.place(a, RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1 / 3, -2e-9, 1e3]))
    shown.place(b, RigidTransform())
    return shown.poses()


def test_yaml_is_that_of_a_scene_file(poses):
    read = read_scene('sources: ["s, <b>"]\n' + as_yaml(poses))
    assert [(frame.source, frame.name) for frame in read.frames] == list(poses)
    for frame, X_PF in zip(read.frames, poses.values(), strict=True):
        assert frame.X_PF.IsExactlyEqualTo(X_PF)


def test_csv_is_a_pose_file(poses, tmp_path):
    path = tmp_path / 'poses.csv'
    path.write_text(as_csv(poses))
    (moment,) = read_poses(path)
    assert [pose.frame for pose in moment.poses] == list(map(full_name, poses))
    for pose, X_PF in zip(moment.poses, poses.values(), strict=True):
        assert pose.X_PF.IsNearlyEqualTo(X_PF, 1e-15)


def test_names_with_colons_stay_apart_in_yaml_and_are_refused_in_csv():
    text = "sources: [a, 'a::b']\nframes: [{name: 'b::c', source: a}, {name: c, source: 'a::b'}]\n"
    shown = local_scene(text)
    for x, frame in enumerate(shown.frames):
        shown.place(frame, RigidTransform([x, 0.0, 0.0]))
    poses = shown.poses()
    assert list(poses) == [('a', 'b::c'), ('a::b', 'c')]
    read = read_scene("sources: [a, 'a::b']\n" + as_yaml(poses))
    assert [(f.source, f.name, f.X_PF.translation()[0]) for f in read.frames] == [
        *(('a', 'b::c', 0.0), ('a::b', 'c', 1.0))
    ]
    with pytest.raises(AmbiguousNameError, match='rename one'):
        as_csv(poses)
