"""Cameras that a node cannot publish are refused at each door; one that fails stops no other."""

from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import Topic, live_scene

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.scene.changes.addition import addition, exchange
from drake_geom_ros.live.scene.prepared_scene import prepared
from drake_geom_ros.live.scene.scene_cameras import LONGEST_TOPIC, CameraLimits
from drake_geom_ros.ros.outputs.cameras import CameraPublisher
from drake_geom_ros.scene_files import SceneFileError, read_scene

SCENE = """
cameras:
- {{name: {}, size: [{}, {}], images: [color, depth]}}
"""


def text(name='a', width=64, height=48):
    return SCENE.format(name, width, height)


@pytest.fixture
def live():
    live = live_scene(text())
    live.name_cameras_for('/cell/scene_graph')
    live.most_megabytes = 1.0
    return live


LONG = LONGEST_TOPIC - len('/cell/scene_graph/cameras//depth/image_rect_raw')
BAD = {
    'name': (text('n' * (LONG + 1)), rf'{LONG} are the most'),
    'size': (text('big', 1000, 500), r'take 4.0 MB; the parameter max_answer_size allows 1 MB'),
}


@pytest.mark.parametrize(('bad', 'word'), BAD.values(), ids=BAD)
def test_a_camera_is_refused_at_each_door(live, bad, word):
    description = read_scene(bad)
    (camera,) = description.cameras
    with live.editing() as scene:
        with pytest.raises(ArgumentError, match=word):
            scene.cameras.add(scene.model.names.world, camera)
        with pytest.raises(SceneFileError, match=rf'<text>:3: cameras\[0\]: .*{word}'):
            scene.make(addition(description))
        with pytest.raises(SceneFileError, match=word):
            scene.replace(prepared(description))
        with pytest.raises(SceneFileError, match=word):
            scene.make(
                exchange(scene, [scene.model.names.source('SceneGraphInternal')], description)
            )
        assert scene.cameras.by_name().keys() == {'a'}


def test_the_longest_name_and_the_largest_images_are_taken(live):
    with live.editing() as scene:
        scene.make(addition(read_scene(text('n' * LONG, 500, 250))))
        assert len(scene.cameras.by_name()) == 2


def test_a_bare_scene_has_no_limits():
    (camera,) = read_scene(text('n' * 500, 16384, 16384)).cameras
    assert CameraLimits().refusal(camera) == ''


class Surface:
    """Opens topics, but none whose name has a letter that the middleware does not take."""

    def __init__(self):
        self.open = []

    def publisher(self, kind, topic, profile, comes_and_goes=False):
        assert comes_and_goes or 'cameras' not in topic
        if 'q' in topic and 'depth' in topic:
            raise RuntimeError('no such topic')
        publisher = Topic(listeners=0)
        publisher.of_camera = 'cameras' in topic
        self.open.append(publisher)
        return publisher

    def close_publisher(self, publisher):
        self.open.remove(publisher)


def test_a_camera_whose_topics_do_not_open_stops_no_other_and_leaks_none():
    live = live_scene(text('a'))
    with live.editing() as scene:
        for name in ('q', 'z'):
            scene.make(addition(read_scene(text(name))))
    surface = Surface()
    cameras = CameraPublisher(live, surface, *[Plain()] * 3)
    for _ in range(5):
        cameras.publish()
    assert sum(each.of_camera for each in surface.open) == 8
    with live.editing() as scene:
        (told,) = [each for each in scene.log.warnings if 'camera' in each]
        assert "'q' cannot be opened" in told
        scene.cameras.remove('q')
    cameras.publish()
    assert sum(each.of_camera for each in surface.open) == 8
