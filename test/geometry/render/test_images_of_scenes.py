"""Images follow the scene: who is seen, with which label and colour, and when."""

import copy
import math

import numpy as np
import pytest
from geometry.render.scenes import NAME, images, instance, properties, query_of, scene_of

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    ClippingRange,
    ColorRenderCamera,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    IllustrationProperties,
    MakeRenderEngineExact,
    MeshcatCone,
    PerceptionProperties,
    ProximityProperties,
    RenderCameraCore,
    RenderEngineExactParams,
    RenderLabel,
    Rgba,
    Role,
    RoleAssign,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.render import CameraProperties, DepthCameraProperties
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensors import CameraInfo


def camera_of(name):
    """Return a camera whose middle pixel, (4, 3), looks straight ahead."""
    info = CameraInfo(9, 7, 10.0, 10.0, 4.5, 3.5)
    return ColorRenderCamera(RenderCameraCore(name, info, ClippingRange(0.01, 100.0)))


CAMERA = camera_of(NAME)
EMPTY = int(RenderLabel.kEmpty)
AHEAD = RigidTransform([0.0, 0.0, 3.0])


def middle(made):
    """Return depth and label in the middle of the images."""
    return float(made.depth.at(4, 3)[0]), int(made.label.at(4, 3)[0])


def test_depth_is_along_the_axis_and_beyond_the_range_0_or_infinite():
    scene, _ = scene_of([(Box(10, 10, 1), AHEAD)])
    W, pose = scene.world_frame_id(), RigidTransform()

    def depth(near, far):
        camera = DepthCameraProperties(9, 7, 1.5, NAME, near, far)
        return np.unique(query_of(scene).RenderDepthImage(camera, W, pose).data).tolist()

    assert depth(0.1, 10.0) == [2.5]
    assert depth(2.6, 10.0) == [0.0]
    assert depth(0.1, 2.4) == [math.inf]
    assert depth(2.5, 2.6) == [2.5]


def test_what_is_registered_removed_posed_or_changed_later_is_in_the_next_image():
    scene, source = scene_of([])
    frame = scene.RegisterFrame(source, GeometryFrame('f'))
    context = scene.CreateDefaultContext()
    query = scene.get_query_output_port().Eval(context)

    def look():
        return middle(query.render_images(CAMERA, scene.world_frame_id(), RigidTransform()))

    context.UpdateFramePoses(FramePoseVector({frame: AHEAD}))
    assert look() == (math.inf, EMPTY)
    ball = instance(Sphere(0.5), RigidTransform(), 'ball', properties(7))
    scene.RegisterGeometry(context, source, frame, ball)
    assert look() == (2.5, 7)
    baked = copy.copy(query)
    context.UpdateFramePoses(FramePoseVector({frame: RigidTransform([0, 0, 4.0])}))
    assert look() == (3.5, 7)
    scene.ChangeShape(context, source, ball.id(), Sphere(1.0))
    assert look() == (3.0, 7)
    scene.AssignRole(context, source, ball.id(), properties(8), RoleAssign.kReplace)
    assert look() == (3.0, 8)
    scene.RemoveRole(context, source, ball.id(), Role.kPerception)
    assert look() == (math.inf, EMPTY)
    assert middle(baked.render_images(CAMERA, scene.world_frame_id(), RigidTransform())) == (
        2.5,
        7,
    )


def test_a_camera_rides_on_its_frame():
    scene, source = scene_of([(Sphere(0.5), RigidTransform([5.0, 0.0, 3.0]))])
    frame = scene.RegisterFrame(source, GeometryFrame('hand'))
    context = scene.CreateDefaultContext()
    context.UpdateFramePoses(FramePoseVector({frame: RigidTransform([4.0, 0.0, 0.0])}))
    query = scene.get_query_output_port().Eval(context)
    made = query.render_images(CAMERA, frame, RigidTransform([1.0, 0.0, 0.0]))
    assert middle(made) == (2.5, 0)


def test_only_the_perception_role_is_seen_and_what_accepts_the_renderer():
    scene, source = scene_of([])
    scene.AddRenderer('other', MakeRenderEngineExact())
    unseen = GeometryInstance(RigidTransform([0, 0, 1.0]), Sphere(0.2), 'unseen')
    unseen.set_proximity_properties(ProximityProperties())
    unseen.set_illustration_properties(IllustrationProperties())
    scene.RegisterAnchoredGeometry(source, unseen)
    picky = properties(1)
    picky.AddProperty('renderer', 'accepting', {'other', 'a third'})
    scene.RegisterAnchoredGeometry(source, instance(Sphere(0.5), AHEAD, 'picky', picky))
    assert middle(images(scene, CAMERA)) == (math.inf, EMPTY)
    assert middle(images(scene, camera_of('other'))) == (2.5, 1)


def test_a_set_of_no_renderers_is_all_of_them():
    """As in Drake's ``GeometryState``."""
    scene, source = scene_of([])
    of_any = properties(1)
    of_any.AddProperty('renderer', 'accepting', set())
    scene.RegisterAnchoredGeometry(source, instance(Sphere(0.5), AHEAD, 'of any', of_any))
    assert middle(images(scene, CAMERA)) == (2.5, 1)


def test_a_renderer_of_another_role_shows_what_distances_are_of():
    scene, source = scene_of([], role=Role.kProximity, number_geometries=True)
    ball = GeometryInstance(AHEAD, Sphere(0.5), 'ball')
    ball.set_proximity_properties(ProximityProperties())
    scene.RegisterAnchoredGeometry(source, ball)
    assert middle(images(scene, CAMERA)) == (2.5, 1)
    assert query_of(scene).render_legend(NAME) == {ball.id(): 1}


def test_labels():
    """What is not to be rendered shows what is behind it, in label images only."""
    scene, source = scene_of([(Box(1, 1, 1), RigidTransform([0, 0, 5.0]))])
    hidden = PerceptionProperties()
    hidden.AddProperty('label', 'id', RenderLabel.kDoNotRender)
    scene.RegisterAnchoredGeometry(source, instance(Sphere(0.5), AHEAD, 'hidden', hidden))
    assert middle(images(scene, CAMERA)) == (2.5, 0)
    scene.RegisterAnchoredGeometry(source, instance(Sphere(0.5), RigidTransform([0, 0, 2.0])))
    assert middle(images(scene, CAMERA)) == (1.5, int(RenderLabel.kDontCare))


def test_a_missing_label_is_refused_where_the_default_is_unspecified():
    scene, source = scene_of([], default_label=RenderLabel.kUnspecified)
    scene.RegisterAnchoredGeometry(source, instance(Sphere(0.5), AHEAD, 'ball'))
    with pytest.raises(RuntimeError, match=r"'ball'.*\('label', 'id'\)"):
        images(scene, CAMERA)


@pytest.mark.parametrize('label', [RenderLabel.kEmpty, RenderLabel.kUnspecified, 40000, -1, 'a'])
def test_labels_that_are_none_are_refused(label):
    scene, source = scene_of([])
    made = PerceptionProperties()
    made.AddProperty('label', 'id', label)
    scene.RegisterAnchoredGeometry(source, instance(Sphere(0.5), AHEAD, 'ball', made))
    with pytest.raises(RuntimeError):
        images(scene, CAMERA)


def test_colours_are_the_bodies_own_and_lit_from_the_camera():
    scene, source = scene_of([], default_clear_color=Rgba(0, 0, 1), edges=False)
    red = instance(Sphere(0.5), AHEAD, 'red', properties(1, (1.0, 0.0, 0.0)))
    scene.RegisterAnchoredGeometry(source, red)
    image = images(scene, CAMERA).color
    assert image.at(0, 0).tolist() == [0, 0, 255, 255]
    r, g, b, a = image.at(4, 3).tolist()
    assert (g, b, a) == (0, 0, 255)
    assert r > 180


def test_finer_colours_leave_depth_and_label_alone_and_mix_at_edges():
    bodies = [(Box(0.8, 0.8, 0.8), RigidTransform([0.03, 0.02, 3.0]))]
    coarse = images(scene_of(bodies, edges=False)[0], CAMERA)
    fine = images(scene_of(bodies, edges=False, color_samples=4)[0], CAMERA)
    assert fine.depth == coarse.depth
    assert fine.label == coarse.label
    few, many = (len(np.unique(made.color.data.reshape(-1, 4), axis=0)) for made in (coarse, fine))
    assert few < many


def test_images_of_one_scene_are_the_same_to_the_last_bit(monkeypatch):
    """Whatever the bands that they are drawn in, and however often."""
    from drake_geom_ros.geometry._rendering import drawing

    random = np.random.default_rng(4)
    bodies = [
        (Sphere(0.3), RigidTransform(random.uniform([-1, -1, 2], [1, 1, 4]))) for _ in range(9)
    ]
    bodies.append((Capsule(0.2, 4.0), RigidTransform([0.1, 0, 2.5])))
    camera = CameraProperties(64, 48, 0.9, NAME)
    scene, _ = scene_of(bodies, color_samples=2)
    plain, _ = scene_of(bodies)
    first = images(scene, camera), images(plain, camera)
    monkeypatch.setattr(drawing, 'BAND_PIXELS', 64 * 5)
    again = images(scene, camera), images(plain, camera)
    for a, b in zip(first, again, strict=True):
        assert (a.color, a.depth, a.label) == (b.color, b.depth, b.label)


def test_one_pixel_and_8k():
    scene, _ = scene_of([(HalfSpace(), RigidTransform([0, 0, 3.0]))])
    one = images(scene, CameraProperties(1, 1, 1.0, NAME))
    assert one.depth.data.tolist() == [[[3.0]]]
    large = images(scene, CameraProperties(7680, 4320, 1.0, NAME), want='label').label
    assert large.shape == (4320, 7680, 1)
    assert (large.data == 0).all()


def test_frames_without_a_pose_are_waited_for_or_left_out():
    scene, source = scene_of([(Sphere(0.5), AHEAD)])
    frame = scene.RegisterFrame(source, GeometryFrame('late'))
    late = instance(Sphere(0.5), RigidTransform(), 'late', properties(5))
    scene.RegisterGeometry(source, frame, late)
    with pytest.raises(RuntimeError, match='late'):
        images(scene, CAMERA)
    context = scene.CreateSharedContext(partial=True)
    query = scene.get_query_output_port().Eval(context)
    W = scene.world_frame_id()
    assert middle(query.render_images(CAMERA, W, RigidTransform())) == (2.5, 0)


@pytest.mark.parametrize(
    ('shape', 'pose'),
    [
        (Sphere(1e70), AHEAD),
        (Box(1e-70, 1, 1), AHEAD),
        (Sphere(1.0), RigidTransform([1e80, 0, 0])),
        (MeshcatCone(1.0, 1.0, 1.0), AHEAD),
    ],
)
def test_what_images_cannot_show_is_refused_by_name(shape, pose):
    scene, _ = scene_of([(shape, pose)])
    with pytest.raises(RuntimeError, match="geometry '0'"):
        images(scene, CAMERA)


def test_an_empty_scene():
    made = images(scene_of([])[0], CAMERA)
    assert middle(made) == (math.inf, EMPTY)
    background = RenderEngineExactParams().default_clear_color.rgba
    assert made.color.at(0, 0).tolist() == np.round(255 * background).tolist()


def test_a_thousand_images_leave_no_memory_behind():
    import resource

    scene, _ = scene_of([(Sphere(0.5), AHEAD)])
    query, camera = query_of(scene), CameraProperties(64, 48, 0.6, NAME)
    W, pose = scene.world_frame_id(), RigidTransform()
    query.render_images(camera, W, pose)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(1000):
        query.render_images(camera, W, pose)
    # An image of each kind has 28 kB: a thousand kept were 28 MB.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 10_000


def test_a_scene_without_renderers_says_so():
    scene = SceneGraph()
    with pytest.raises(RuntimeError, match=f"no renderer '{NAME}', there is none"):
        images(scene, CAMERA)
