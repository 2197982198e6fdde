"""Publishes what cameras see, beside the cycle: nothing for nobody, nothing twice."""

from __future__ import annotations

import importlib.util
import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from drake_geom_msgs.msg import LabelLegend
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.live.conversions.cameras import (
    fill_camera_info,
    fill_header,
    fill_image,
    fill_legend,
    optical_frame,
)
from drake_geom_ros.live.outputs.effects import NO_SUBSCRIBER, Beside
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.outputs.unlocked import publish
from drake_geom_ros.scene_files import CameraDescription, camera_of

PERIOD = 0.05  # [s] at most between two looks which cameras there are, and which is due
_SOON = 0.002  # [s] at least, so that others may have the lock of the scene
_AGAIN = 1.0  # [s] an image that stays the same is sent again, for who came late or lost it
# Where the images of a kind are published, below ~/cameras/NAME.
_TOPICS = {
    'color': ('color', 'color/image_raw'),
    'depth': ('depth', 'depth/image_rect_raw'),
    'label': ('labels', 'labels/image_raw'),
}
_LEGEND = 'labels/legend'


@dataclass
class _OpenCamera:
    """A camera with its topics, and what was published last."""

    frame: FrameId
    camera: CameraDescription
    publishers: dict[str, Any]  # by kind; 'KIND info' and 'legend' too
    due: float = 0.0  # [s]
    state: bytes = b''
    sent: float = 0.0  # [s]
    X_WC: RigidTransform | None = None  # when the images were taken; None: it rests
    messages: dict[str, tuple[Any, Any]] = field(default_factory=dict)  # image, intrinsics
    legend_version: int = -1  # of the scene

    def heard(self) -> list[str]:
        """Return the kinds of images that somebody listens to, or to the intrinsics of."""
        return [
            kind
            for kind in self.camera.images
            if self.publishers[kind].get_subscription_count()
            or self.publishers[f'{kind} info'].get_subscription_count()
            or (kind == 'label' and self.publishers['legend'].get_subscription_count())
        ]


class CameraPublisher:
    """Takes the images that are due, in one thread, each time it is called."""

    def __init__(
        self,
        live: LiveScene,
        surface: Any,
        images: Any,
        latched: Any,
        transforms: Any,
    ) -> None:
        """Take the profiles of images, of legends and /tf_static, and of /tf."""
        self._live = live
        self._surface = surface
        self._images, self._latched = images, latched
        self._transforms = CameraTransforms(surface, live.world_frame, latched, transforms)
        self.beside = Beside.publishing(
            'cameras', self._why_not
        )  # what is told in the report of a cycle
        self._open: dict[str, _OpenCamera] = {}
        self._unheard, self._unchanged = 0, 0  # times that a camera was due, since last told

    def _why_not(self) -> str:
        """Return why no image was taken since this was last asked for."""
        unheard, self._unheard = self._unheard, 0
        unchanged, self._unchanged = self._unchanged, 0
        if unchanged:
            return f'nothing moved: {unchanged} times an image was not taken again'
        if unheard:
            return NO_SUBSCRIBER
        return 'no camera was due' if self._open else 'no cameras'

    def publish(self) -> float:
        """Take the images that are due, publish them, and return when to look again [s]."""
        self._follow()
        self._publish_due(time.monotonic())
        soonest = min((each.due for each in self._open.values()), default=math.inf)
        return min(max(soonest - time.monotonic(), _SOON), PERIOD)

    def _publish_due(self, now: float) -> None:
        due = [each for each in self._open.values() if each.due <= now]
        heard = [(each, kinds) for each in due if (kinds := each.heard())]
        for each in due:
            period = 1.0 / each.camera.rate
            # In step with its rate, unless it is late by more than a period.
            each.due = each.due + period if each.due + period > now else now + period
        self._unheard += len(due) - len(heard)
        if not heard:
            return
        with self._live.reading() as scene:
            cameras, view = scene.cameras.by_name(), scene.view()
        state = view.query.image_state()
        for each, kinds in heard:
            is_there = cameras.get(each.camera.name) == (each.frame, each.camera)
            if is_there and view.query.is_placed(each.frame):
                self._show(each, kinds, view, state, now)

    def _show(
        self, each: _OpenCamera, kinds: list[str], view: SceneView, state: bytes, now: float
    ) -> None:
        """Publish images of a camera, taken now where something moved."""
        if each.state != state or not each.messages.keys() >= set(kinds):
            start = time.perf_counter()
            self._take(each, kinds, view)
            each.state = state
            self.beside.did(len(kinds), time.perf_counter() - start)
        else:
            self._unchanged += 1
            if now < each.sent + _AGAIN:
                return
        each.sent = now
        if each.X_WC is not None:
            stamp = each.messages[kinds[0]][0].header.stamp
            self._transforms.move(each.camera, each.X_WC, stamp)
        for kind in kinds:
            image, info = each.messages[kind]
            each.publishers[f'{kind} info'].publish(info)
            publish(each.publishers[kind], image)

    def _take(self, each: _OpenCamera, kinds: list[str], view: SceneView) -> None:
        """Take images of a camera, and keep them as messages."""
        camera, stamp = each.camera, view.moment.newest_stamp
        images = view.query.render_images(camera_of(camera), each.frame, camera.X_FC, kinds)
        if each.frame != view.names.world:
            each.X_WC = view.query.X_WF(each.frame) @ camera.X_FC
        # What was published is written over: room for an image is slow to come by.
        room, each.messages = each.messages, {}
        for kind in kinds:
            image, info = room.get(kind) or (Image(), CameraInfo())
            fill_image(image, kind, getattr(images, kind).data)
            fill_camera_info(info, camera)
            for message in (image, info):
                fill_header(message, camera, stamp)
            each.messages[kind] = image, info
        if 'label' in kinds and each.legend_version != view.moment.version:
            each.legend_version = view.moment.version
            legend = LabelLegend(scene_version=view.moment.version)
            renderer = camera_of(camera).core().renderer_name()
            fill_legend(legend, view.query.render_legend(renderer), view.names)
            fill_header(legend, camera, stamp)
            each.publishers['legend'].publish(legend)

    def _follow(self) -> None:
        """Open and close topics as cameras come and go."""
        with self._live.reading() as scene:
            cameras, world = scene.cameras.by_name(), scene.model.names.world
        gone = [
            name
            for name, each in self._open.items()
            if cameras.get(name) != (each.frame, each.camera)
        ]
        for name in gone:
            for publisher in self._open.pop(name).publishers.values():
                self._surface.close_publisher(publisher)
        new = cameras.keys() - self._open.keys()
        for name in sorted(new):
            frame, camera = cameras[name]
            try:
                self._open[name] = _OpenCamera(frame, camera, self._publishers(camera))
            except Exception as error:
                # The other cameras go on; this one is looked at again when it is another.
                self._open[name] = _OpenCamera(frame, camera, {}, due=math.inf)
                self._refuse(camera, error)
        if gone or new:
            self._transforms.fix(camera for frame, camera in cameras.values() if frame == world)

    def _refuse(self, camera: CameraDescription, error: Exception) -> None:
        """Warn that nothing of a camera is published."""
        with self._live.editing() as scene:
            scene.log.warnings.append(
                f'the topics of the camera {camera.name[:80]!r} cannot be opened, so nothing of '
                f'it is published: {error}'
            )

    def _publishers(self, camera: CameraDescription) -> dict[str, Any]:
        """Open the topics of a camera."""
        base = f'~/cameras/{camera.name}'
        wanted: dict[str, Any] = {}
        for kind in camera.images:
            folder, topic = _TOPICS[kind]
            wanted[kind] = Image, f'{base}/{topic}', self._images
            wanted[f'{kind} info'] = CameraInfo, f'{base}/{folder}/camera_info', self._images
        if 'label' in camera.images:
            wanted['legend'] = LabelLegend, f'{base}/{_LEGEND}', self._latched
        opened: dict[str, Any] = {}
        try:
            for name, how in wanted.items():
                opened[name] = self._surface.publisher(*how, comes_and_goes=True)
        except Exception:
            # Whatever the middleware says: half a camera would stay open for good.
            for publisher in opened.values():
                self._surface.close_publisher(publisher)
            raise
        return opened


class CameraTransforms:
    """Sends X_WC of cameras, in whose optical frames (REP 103) x is to the right, z ahead.

    Their parent is the world, not the frames that carry them: those are posed by messages
    and need not be in TF. Nothing is opened before there is a camera, and nothing is sent without
    tf2_msgs, which not everybody has.
    """

    def __init__(self, surface: Any, world_frame: str, resting: Any, moving: Any) -> None:
        """``resting`` and ``moving`` are the profiles of /tf_static and /tf."""
        self._surface, self._world_frame = surface, world_frame
        self._profiles = {'/tf_static': resting, '/tf': moving}
        self._publishers: dict[str, Any] = {}
        self._fixed: list[str] = []  # the cameras that were told to rest

    def fix(self, cameras: Iterable[CameraDescription]) -> None:
        """Send all cameras that are fixed in the world, latched for late subscribers."""
        fixed = list(cameras)
        if fixed or self._fixed:
            self._fixed = [camera.name for camera in fixed]
            self._send('/tf_static', [self._entry(camera, camera.X_FC) for camera in fixed])

    def move(self, camera: CameraDescription, X_WC: RigidTransform, stamp: Any) -> None:
        """Send the pose of a camera when its image was taken."""
        self._send('/tf', [self._entry(camera, X_WC, stamp)])

    def _send(self, topic: str, entries: list[TransformStamped]) -> None:
        if importlib.util.find_spec('tf2_msgs') is None:
            return
        from tf2_msgs.msg import TFMessage

        if topic not in self._publishers:
            profile = self._profiles[topic]
            self._publishers[topic] = self._surface.publisher(TFMessage, topic, profile)
        self._publishers[topic].publish(TFMessage(transforms=entries))

    def _entry(
        self, camera: CameraDescription, X_WC: RigidTransform, stamp: Any = None
    ) -> TransformStamped:
        entry = TransformStamped(child_frame_id=optical_frame(camera))
        entry.header.frame_id = self._world_frame
        if stamp is not None:
            entry.header.stamp = stamp
        p, q = entry.transform.translation, entry.transform.rotation
        p.x, p.y, p.z, q.x, q.y, q.z, q.w = X_WC.ToArray().tolist()
        return entry
