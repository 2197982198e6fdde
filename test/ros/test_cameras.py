"""Cameras on the real node: topics, services, what is not rendered, and what is saved."""

import math

import numpy as np
import pytest
from drake_geom_msgs import msg, srv
from geometry_msgs.msg import Point, Pose, Quaternion
from ros.harness import LATCHED
from ros.scene_calls import poses
from sensor_msgs.msg import CameraInfo, Image

from drake_geom_ros.scene_files import read_scene

pytestmark = pytest.mark.topics

SCENE = """
sources: [s]
frames: [{name: a, source: s, pose: {position: [0, 0, 2]}}, {name: hand, source: s}]
geometries:
- {name: g, source: s, frame: a, shape: {type: sphere, radius: 0.5},
   roles: {perception: {phong: {diffuse: {rgba: [1, 0, 0, 1]}}, label: {id: 9}}}}
cameras:
- {name: eye, size: [9, 7], intrinsics: [10, 10, 4.5, 3.5], rate: 50}
- {name: idle, size: [9, 7], frame: hand}
"""
EMPTY = 32766
EYE = 'cameras/eye'


@pytest.fixture(scope='module')
def node(shared_node):
    shared_node.load(SCENE)
    return shared_node.process


def pixels(image, dtype):
    return np.frombuffer(bytes(image.data), dtype).reshape(image.height, image.width, -1)


def camera(**fields):
    given = {'width': 9, 'height': 7, 'intrinsics': [10.0, 10.0, 4.5, 3.5], **fields}
    return msg.Camera(**given)


def render(client, **fields):
    answer = client.call(srv.RenderImage, 'render_image', **fields)
    assert answer.success, answer.message
    return answer


def test_a_service_takes_images_of_what_if(client):
    live = render(client, camera='eye')
    assert pixels(live.depth, np.float32)[3, 4, 0] == 1.5
    assert pixels(live.label, np.int16)[3, 4, 0] == 9
    assert pixels(live.color, np.uint8)[3, 4].tolist()[1:] == [0, 0]
    assert (live.color.encoding, live.depth.encoding, live.label.encoding) == (
        *('rgb8', '32FC1', '16SC1'),
    )
    assert (live.color.step, live.depth.step, live.label.step) == (27, 36, 18)
    assert live.depth.header.frame_id == 'eye_optical_frame'
    assert list(live.legend.labels) == [9]
    assert live.legend.geometries == ['s::a/g']
    moved = render(client, camera='eye', poses=poses(['a'], [(0, 0, 4)], 's'), images=['depth'])
    assert pixels(moved.depth, np.float32)[3, 4, 0] == 3.5
    assert (moved.color.width, moved.label.width) == (0, 0)
    assert pixels(render(client, camera='eye').depth, np.float32)[3, 4, 0] == 1.5


def test_intrinsics_are_those_of_ros(client):
    """The middle of pixel u is at u there, and the middle pixel looks along the axis."""
    info = render(client, camera='eye', images=['depth']).camera_info
    assert list(info.k) == [10, 0, 4, 0, 10, 3, 0, 0, 1]
    assert list(info.p) == [10, 0, 4, 0, 0, 10, 3, 0, 0, 0, 1, 0]
    assert (info.width, info.height, info.distortion_model) == (9, 7, 'plumb_bob')
    assert info.header.frame_id == 'eye_optical_frame'


def test_a_camera_may_be_given_with_the_request(client):
    pose = Pose(position=Point(x=0.0, y=0.0, z=1.0), orientation=Quaternion(w=1.0))
    answer = render(client, given=camera(pose=pose), images=['depth'])
    assert pixels(answer.depth, np.float32)[3, 4, 0] == 0.5
    wide = msg.Camera(width=8, height=6, fov_y=math.pi / 2)
    assert render(client, given=wide, images=['label']).camera_info.k[0] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ('fields', 'why'),
    [
        ({'camera': 'eyes'}, "no camera 'eyes'"),
        ({'given': camera(width=0)}, 'width = 0'),
        ({'given': camera(frame='nowhere')}, "no frame 'nowhere'"),
        ({'given': camera(near=3.0, far=2.0)}, 'near < far'),
        ({'given': camera(images=['colour'])}, 'colour'),
        ({'given': camera(shows='all')}, 'perception, proximity'),
        ({'given': camera(width=20000)}, '20000'),
        ({'camera': 'eye', 'images': ['colour']}, 'colour'),
        ({'camera': 'idle'}, 'hand'),
    ],
)
def test_what_cannot_be_is_refused(client, fields, why):
    answer = client.call(srv.RenderImage, 'render_image', **fields)
    assert not answer.success
    assert why in answer.message


def test_images_come_while_somebody_listens_and_follow_the_poses(client):
    infos = client.listen(CameraInfo, f'{EYE}/depth/camera_info')
    depths = client.listen(Image, f'{EYE}/depth/image_rect_raw')
    legends = client.listen(msg.LabelLegend, f'{EYE}/labels/legend', LATCHED)
    labels = client.listen(Image, f'{EYE}/labels/image_raw')
    client.wait_for(lambda: depths and labels and infos and legends, 'images and a legend')
    assert pixels(labels[-1], np.int16)[3, 4, 0] == 9
    assert pixels(labels[-1], np.int16)[0, 0, 0] == EMPTY
    assert (list(legends[-1].labels), legends[-1].geometries) == ([9], ['s::a/g'])
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 10)

    def seen_at(z, stamp):
        # Again and again: a server that has not found the publisher yet takes nothing of it.
        publisher.publish(poses(['a'], [(0, 0, z)], 's', stamp=stamp))
        return pixels(depths[-1], np.float32)[3, 4, 0] == z - 0.5

    client.wait_for(lambda: seen_at(3, 7), 'an image of the new pose')
    client.wait_for(lambda: infos[-1].header.stamp.sec == 7, 'its intrinsics')
    assert depths[-1].header.stamp.sec == 7
    client.wait_for(lambda: seen_at(2, 8), 'the old pose again')
    assert depths[-1].header.stamp.sec == 8


def test_nothing_is_taken_for_nobody_and_nothing_twice(client):
    """Reports say why: first nobody listens, then nothing moves."""
    reports = client.listen(msg.CycleReport, 'cycle_report')
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 10)

    def told(stamp, wanted):
        publisher.publish(poses(['a'], [(0, 0, 2)], 's', stamp=stamp))
        if not reports:
            return None
        row = reports[-1].effects.index('publish ~/cameras')
        reason = reports[-1].effect_reasons[row]
        return wanted in reason and not reports[-1].effect_ran[row]

    stamps = iter(range(10, 10_000))
    client.wait_for(lambda: told(next(stamps), 'no subscriber'), 'a word of no subscriber')
    listened = client.listen(Image, f'{EYE}/color/image_raw')
    client.wait_for(lambda: listened, 'an image')
    client.wait_for(lambda: told(next(stamps), 'nothing moved'), 'a word of images at rest')


def test_optical_frames_are_in_tf(client):
    """In the world: latched where a camera rests, with the stamp of the image where it moves."""
    tf = pytest.importorskip('tf2_msgs.msg', reason='`./run test` builds it where it is missing')
    fixed = client.listen(tf.TFMessage, '/tf_static', LATCHED)
    moving = client.listen(tf.TFMessage, '/tf', 100)
    pose = Pose(position=Point(x=0.5), orientation=Quaternion(z=1.0, w=0.0))
    rider = camera(name='rider', frame='a', pose=pose, images=['depth'], rate=50.0)
    assert client.call(srv.AddCamera, 'add_camera', camera=rider).success
    depths = client.listen(Image, 'cameras/rider/depth/image_rect_raw')
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 10)

    def moved():
        # Again and again: a server that has not found the publisher yet takes nothing of it.
        publisher.publish(poses(['a'], [(1, 2, 3)], 's', stamp=9))
        return told(moving, 'rider', 9)

    def told(messages, name, stamp):
        entries = [entry for message in messages for entry in message.transforms]
        wanted = f'{name}_optical_frame', 'world', stamp
        return [
            entry.transform
            for entry in entries
            if (entry.child_frame_id, entry.header.frame_id, entry.header.stamp.sec) == wanted
        ]

    client.wait_for(moved, 'the optical frame of a camera that moves')
    X = told(moving, 'rider', 9)[-1]
    assert (X.translation.x, X.translation.y, X.translation.z) == (1.5, 2.0, 3.0)
    assert (X.rotation.x, X.rotation.y, abs(X.rotation.z), X.rotation.w) == (0, 0, 1, 0)
    client.wait_for(lambda: depths and depths[-1].header.stamp.sec == 9, 'its image')
    client.wait_for(lambda: told(fixed, 'eye', 0), 'the optical frame of a camera that rests')
    assert told(fixed, 'eye', 0)[-1].rotation.w == 1.0
    assert not told(fixed, 'rider', 0)
    assert not told(moving, 'eye', 9)
    assert client.call(srv.RemoveCamera, 'remove_camera', name='rider').success


def test_cameras_are_added_listed_saved_and_removed(client):
    new = camera(name='new', frame='a', near=0.1, images=['label'], rate=50.0)
    assert client.call(srv.AddCamera, 'add_camera', camera=new).success
    again = client.call(srv.AddCamera, 'add_camera', camera=new)
    assert (again.success, "'new' already" in again.message) == (False, True)
    bad = client.call(srv.AddCamera, 'add_camera', camera=camera(name='a b'))
    assert (bad.success, "'a b'" in bad.message) == (False, True)
    listed = client.call(srv.ListCameras, 'list_cameras').cameras
    assert [(c.name, c.frame) for c in listed] == [
        *(('eye', 'world'), ('idle', 's::hand'), ('new', 's::a')),
    ]
    assert (listed[2].near, listed[2].far, list(listed[2].images)) == (0.1, 100.0, ['label'])
    assert list(listed[2].intrinsics) == [10.0, 10.0, 4.5, 3.5]
    labels = client.listen(Image, 'cameras/new/labels/image_raw')
    client.wait_for(lambda: labels, 'an image of the new camera')
    assert (pixels(labels[-1], np.int16) == 9).all()  # from within the ball
    saved = client.call(srv.SaveScene, 'save_scene').text
    assert [(c.name, c.frame) for c in read_scene(saved).cameras] == [
        *(('eye', 'world'), ('idle', 'hand'), ('new', 'a')),
    ]
    assert client.call(srv.RemoveCamera, 'remove_camera', name='new').success
    topics = dict.fromkeys(['/scene_graph/cameras/new/labels/image_raw'])

    def gone():
        return client.node.count_publishers(*topics) == 0

    client.wait_for(gone, 'the end of its topics')
    loaded = client.call(srv.LoadScene, 'load_scene', text=saved, replace=True)
    assert loaded.success, loaded.message
    names = [c.name for c in client.call(srv.ListCameras, 'list_cameras').cameras]
    assert names == ['eye', 'idle', 'new']
    refused = client.call(
        srv.LoadScene, 'load_scene', text='cameras:\n- {name: eye, size: [4, 4]}'
    )
    assert (refused.success, "'eye' already" in refused.message) == (False, True)
    gone = client.call(srv.RemoveCamera, 'remove_camera', name='none')
    assert (gone.success, "no camera 'none'" in gone.message) == (False, True)
