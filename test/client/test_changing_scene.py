"""Scenes that change all the time: every result has names, and no call waits for ever."""

import threading
import time

import pytest
import rclpy
from drake_geom_msgs import msg, srv
from rclpy.executors import SingleThreadedExecutor
from ros.harness import LATCHED, PATIENCE, start_node

from drake_geom_ros.client import NoAnswerError, SceneGraphClient, UnknownNameError

pytestmark = pytest.mark.topics

COUNT = 800  # geometries
PERIOD = 0.2  # [s] between two changes


@pytest.fixture
def crowd(tmp_path):
    """Return the name of a node with many geometries."""
    lines = ['sources: [s]', 'frames: [{name: a, source: s, pose: {}}]', 'geometries:']
    for k in range(COUNT):
        shape, place = '{type: sphere, radius: 0.1}', f'{{position: [{k + 1}, 0, 0]}}'
        lines.append(f'- {{name: b{k}, source: s, pose: {place}, shape: {shape}}}')
    lines.append('- {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}')
    file = tmp_path / 'crowd.yaml'
    file.write_text('\n'.join(lines))
    process = start_node(tmp_path / 'log', name='crowd', scene_file=file, max_distance=3.0)
    yield '/crowd'
    assert process.end() == 0, process.output()


class Observer:
    """What comes on the topics of a node while its scene changes."""

    def __init__(self, client, server):
        self.client = client
        self.handed, self.named, self.published = [], [], set()
        listen = client.node.create_subscription
        listen(msg.Scene, f'{server}/scene', self._take_scene, LATCHED)
        listen(msg.SignedDistancePairs, f'{server}/signed_distances', self._take, 10)
        client.listener.on_signed_distances(self.handed.append)

    def _take_scene(self, message):
        self.published.add(message.names_version)

    def _take(self, message):
        self.named.append((message.scene_version, message.names_version))

    def watch(self, change, enough):
        """Pose a frame all the time, and make changes; ``change`` is given their number.

        Until ``enough`` says so, however slow the machine is.
        """
        self.client.scene()
        end, due, k = time.monotonic() + PATIENCE, 0.0, 0
        while (now := time.monotonic()) < end and not enough():
            self.client.publish_poses({'a': [0, 0, 0.001 * (k % 2), 0, 0, 0, 1]})
            if now > due:
                due, k = now + PERIOD, k + 1
                change(k)
            time.sleep(0.02)
        self.client.wait_for(lambda: len(self.handed) >= len(self.named) - 2, 'the last results')


def test_results_are_handed_on_while_shapes_change(crowd):
    with SceneGraphClient(crowd, patience=PATIENCE) as client:
        observer = Observer(client, crowd)

        def change(k):
            shape = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.1 + 0.001 * (k % 2)])
            client.call('change_shape', geometry='world/b5', shape=shape)

        def enough():
            return len(set(observer.named)) > 5 and len(observer.handed) > 50

        observer.watch(change, enough)
        assert enough()
        # What is told of a scene may come after a result that refers to it.
        client.wait_for(
            lambda: {names for _, names in observer.named} <= observer.published, 'all names'
        )
        assert client.listener.dropped == 0


def test_results_are_handed_on_with_the_very_names_while_things_come_and_go(crowd):
    with SceneGraphClient(crowd, patience=PATIENCE) as client:
        observer = Observer(client, crowd)

        def change(k):
            if k % 2:
                shape = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.1])
                place = {'name': 'guest', 'source': 's', 'frame': 'world', 'shape': shape}
                client.call('register_geometry', roles=[msg.Role(role=1)], **place)
            else:
                client.call('remove_geometry', geometry='world/guest')

        def enough():
            return len({names for _, names in observer.named}) > 3 and len(observer.handed) > 50

        observer.watch(change, enough)
        assert enough()
        assert client.listener.dropped == 0
        for found in observer.handed:
            if found.table.has('guest'):
                assert len(found.between('guest', 'ball')) == 1
            else:
                with pytest.raises(UnknownNameError):
                    found.between('guest', 'ball')


@pytest.fixture
def forgetful():
    """Return the name of a node whose answers refer to names that it never publishes."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node('forgetful', context=context)
    scenes = node.create_publisher(msg.Scene, '~/scene', LATCHED)
    versions = iter(range(1, 10**9, 2))

    def answer(request, response):
        response.success = True
        response.result.names_version = response.result.scene_version = next(versions)
        if request.max_distance:  # later ones come
            version = response.result.names_version + 1
            scenes.publish(msg.Scene(scene_version=version, names_version=version))
        return response

    node.create_service(
        srv.ComputeSignedDistancePairwise, '~/compute_signed_distance_pairwise', answer
    )
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin)
    thread.start()
    yield '/forgetful'
    executor.shutdown()
    context.try_shutdown()
    thread.join()


@pytest.mark.parametrize('max_distance', [float('inf'), 1.0])
def test_the_patience_is_that_of_the_whole_call(forgetful, max_distance, monkeypatch):
    ends, wait_for = set(), SceneGraphClient.wait_for

    def noted(client, fact, what, end=None):
        ends.add(end)
        return wait_for(client, fact, what, end)

    with SceneGraphClient(forgetful, patience=5.0) as client:
        service = 'compute_signed_distance_pairwise'
        while client.services.missing(service):
            time.sleep(0.01)
        monkeypatch.setattr(SceneGraphClient, 'wait_for', noted)
        with pytest.raises(NoAnswerError, match=r'names of the scene|an answer of'):
            client.signed_distances(max_distance)
    assert len(ends) == 1
    assert ends != {None}
