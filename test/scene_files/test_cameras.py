"""Cameras of scene files: read, saved as they are, and refused with the place."""

import pytest

from drake_geom_ros.geometry import (
    GeometryInstance,
    PerceptionProperties,
    RenderLabel,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import (
    SceneFileError,
    add_renderers,
    camera_of,
    load_scene,
    read_scene,
    save_scene,
)
from drake_geom_ros.sensors import CameraInfo

SCENE = """\
frames: [{name: hand, pose: {position: [0, 0, 1]}}, {name: other, parent: hand}]
geometries:
- {name: ball, frame: hand, shape: {type: sphere, radius: 0.1},
   roles: {perception: {label: {id: 7}}}}
cameras:
- {name: plain, size: [64, 48]}
- {name: full, frame: "scene::other", pose: {position: [0, 0, 0.5], rpy: [0.1, 0.2, 0.3]},
   size: [8, 6], intrinsics: [10, 11, 4, 3], near: 0.2, far: 5, rate: 30,
   images: [label, depth], shows: proximity}
"""


def test_a_camera_is_what_the_file_says():
    plain, full = read_scene(SCENE).cameras
    assert (plain.source, plain.frame, plain.X_FC.IsExactlyIdentity()) == ('', 'world', True)
    assert plain.intrinsics == CameraInfo(64, 48, 0.8)
    assert (plain.range, plain.rate, plain.shows) == ((0.01, 100.0), 10.0, 'perception')
    assert plain.images == ('color', 'depth', 'label')
    assert (full.source, full.frame, full.range) == ('scene', 'other', (0.2, 5))
    assert full.intrinsics == CameraInfo(8, 6, 10.0, 11.0, 4.0, 3.0)
    assert (full.rate, full.images, full.shows) == (30, ('label', 'depth'), 'proximity')
    assert camera_of(full).core().renderer_name() == 'exact_proximity'


def test_cameras_are_saved_with_the_name_that_their_frame_has_then():
    scene = SceneGraph()
    loaded = load_scene(SCENE, scene)
    again = read_scene(save_scene(scene, loaded.X_PFs, cameras=loaded.cameras))
    assert again.cameras == read_scene(SCENE).cameras
    scene.RenameFrame(loaded.frames['scene', 'other'], 'wrist')
    again = read_scene(save_scene(scene, loaded.X_PFs, cameras=loaded.cameras))
    assert again.cameras[1].frame == 'wrist'


def test_a_label_is_saved_as_its_number():
    scene = SceneGraph()
    source = scene.RegisterSource('it')
    ball = GeometryInstance(RigidTransform(), Sphere(0.1), 'ball')
    properties = PerceptionProperties()
    properties.AddProperty('label', 'id', RenderLabel(7))
    ball.set_perception_properties(properties)
    scene.RegisterAnchoredGeometry(source, ball)
    assert 'label: {id: 7}' in save_scene(scene)


def test_renderers_are_added_once():
    scene = SceneGraph()
    add_renderers(scene)
    add_renderers(scene)
    assert scene.RegisteredRendererNames() == ['exact', 'exact_proximity']


@pytest.mark.parametrize(
    ('line', 'why'),
    [
        ('{name: a}', 'missing `size`'),
        ('{name: a, size: [0, 4]}', 'must be >= 1'),
        ('{name: a, size: [4, 4], fov_y: 4}', 'fov_y = 4'),
        ('{name: a, size: [4, 4], fov_y: 1, intrinsics: [1, 1, 1, 1]}', 'one of fov_y'),
        ('{name: a, size: [4, 4], intrinsics: [0, 1, 1, 1]}', 'focal_x'),
        ('{name: a, size: [4, 4], near: 3, far: 2}', 'near < far'),
        ('{name: a b, size: [4, 4]}', "'a b' must begin"),
        ('{name: a, size: [4, 4], frame: nowhere}', "'nowhere' is neither"),
        ('{name: a, size: [4, 4], images: [colour]}', 'one of color'),
        ('{name: a, size: [4, 4], images: []}', 'images is empty'),
        ('{name: a, size: [4, 4]}\n- {name: a, size: [4, 4]}', 'there twice'),
        ('{name: a, size: [4, 4], lens: 1}', 'unknown key'),
    ],
)
def test_a_camera_that_is_none_is_refused_with_its_line(line, why):
    with pytest.raises(SceneFileError, match=why) as caught:
        read_scene(f'sources: [s]\ncameras:\n- {line}\n')
    assert caught.value.line in (3, 4)
