"""The scenes of the delay benchmark: files that load, and poses for the frames they name."""

import numpy as np

from bench.ros.scenes import bodies, two_arms
from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.scene_files import read_scene


def test_bodies_sway_about_their_places(tmp_path):
    played = bodies(27, tmp_path)
    scene = read_scene(played.scene_file)
    assert [frame.name for frame in scene.frames] == played.frame_names
    assert len({type(geometry.shape) for geometry in scene.geometries}) == 5
    first, later = played.poses(0.0), played.poses(1.0)
    assert first.shape == (27, 7)
    assert not np.array_equal(first, later)
    assert np.abs(first - later).max() < 0.2
    assert np.array_equal(played.poses(0.0), first)
    FramePoseVector.FromArrays(np.arange(1, 28), first)


def test_the_arms_are_the_demo():
    played = two_arms()
    scene = read_scene(played.scene_file)
    names = {f'{frame.source}::{frame.name}' for frame in scene.frames}
    assert set(played.frame_names) == names
    assert played.poses(3.0).shape == (len(names), 7)
