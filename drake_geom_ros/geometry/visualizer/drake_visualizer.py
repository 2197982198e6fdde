"""``DrakeVisualizer`` without the systems framework: sends load and draw messages by LCM."""

from __future__ import annotations

import math
import warnings
from typing import Any

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError, GeometryError
from drake_geom_ros.geometry.model.links import links_of
from drake_geom_ros.geometry.model.properties import Role
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector, model_version
from drake_geom_ros.geometry.queries.context import SceneGraphContext
from drake_geom_ros.geometry.queries.query_object import QueryObject
from drake_geom_ros.geometry.scene._ports import PoseBundlePort
from drake_geom_ros.geometry.scene.scene_graph import SceneGraph
from drake_geom_ros.geometry.visualizer._messages import draw_messages, load_message

_LOAD, _DRAW = 'DRAKE_VIEWER_LOAD_ROBOT', 'DRAKE_VIEWER_DRAW'
_PERIOD = 1.0 / 60.0  # [s]


def DispatchLoadMessage(
    scene_graph: SceneGraph, lcm: Any, role: Role = Role.kIllustration
) -> None:
    """Send the geometry with a role to Drake's visualiser, on DRAKE_VIEWER_LOAD_ROBOT.

    ``lcm`` is an ``lcm.LCM`` of the library, a ``pydrake.lcm.DrakeLcm``, or any object that
    publishes bytes on a channel. Warns of geometry that cannot be drawn as it is.
    """
    checked_type(scene_graph, SceneGraph, 'DispatchLoadMessage: scene_graph')
    checked_type(role, Role, 'DispatchLoadMessage: role')
    send_load(scene_graph.model_inspector(), lcm, role)


def send_load(inspector: SceneGraphInspector, lcm: Any, role: Role) -> None:
    """Send the message of DispatchLoadMessage for the model of an inspector."""
    message, texts = load_message(inspector, role)
    for text in texts:
        warnings.warn(text, stacklevel=3)
    _publish(lcm, _LOAD, message)


class DrakeVisualizerPublisher:
    """Sends a scene to Drake's visualiser; ``ConnectDrakeVisualizer`` returns it."""

    def __init__(self, lcm: Any, role: Role) -> None:
        self._lcm = lcm
        self._role = role
        self._period = _PERIOD
        self._next = -math.inf
        self._loaded: _Loaded | None = None

    def set_publish_period(self, period: float) -> None:
        """Set the minimum simulated time [s] between two draws; with 0 each call draws."""
        if not period >= 0.0:
            raise ArgumentError(f'set_publish_period: period = {period} must be seconds >= 0')
        self._period = float(period)

    def Publish(self, context: SceneGraphContext, time: float) -> bool:
        """Draw a context at a simulated time [s] if a draw is due, and return whether it was.

        The scene is loaded first if it has changed since, and again if the time has gone back, as
        for a restarted simulation.
        """
        checked_type(context, SceneGraphContext, 'Publish: context')
        query = QueryObject(context)
        inspector = query.inspector()
        again = time < self._next - self._period
        loaded = self._loaded
        if again or loaded is None or not loaded.is_of(inspector):
            send_load(inspector, self._lcm, self._role)
            loaded = self._loaded = _Loaded(inspector, self._role)
            self._next = -math.inf
        if time < self._next:
            return False
        for message in draw_messages(query, loaded.links, time):
            _publish(self._lcm, _DRAW, message)
        self._next = time + self._period
        return True


class _Loaded:
    """The links of a scene that the visualiser has loaded, and the version of the model."""

    def __init__(self, inspector: SceneGraphInspector, role: Role) -> None:
        self._version = model_version(inspector)
        self.links = links_of(inspector, role)

    def is_of(self, inspector: SceneGraphInspector) -> bool:
        """Return whether the model is unchanged since; filters do not count."""
        return self._version == model_version(inspector)


def ConnectDrakeVisualizer(
    builder: None = None,
    scene_graph: SceneGraph | None = None,
    *args: Any,
    lcm: Any = None,
    role: Role = Role.kIllustration,
    pose_bundle_output_port: PoseBundlePort | None = None,
) -> DrakeVisualizerPublisher:
    """Return a publisher that sends a scene to Drake's visualiser at each call of ``Publish``.

    ``builder`` must be None: without diagrams, nothing calls ``Publish`` by itself. After
    ``scene_graph`` follow, as in pydrake, ``lcm`` (None: one of the library ``lcm``, with its
    default network) and ``role``, or before them the ``pose_bundle_output_port`` of the scene
    graph. Raises GeometryError for a builder, and if ``lcm`` is needed and not installed.
    """
    if builder is not None:
        raise GeometryError(
            f'ConnectDrakeVisualizer: builder = {builder!r} was given, and there is no systems '
            'framework here. Give None, and call Publish(context, time) of what is returned '
            'after each step'
        )
    checked_type(scene_graph, SceneGraph, 'ConnectDrakeVisualizer: scene_graph')
    rest = list(args)
    if rest and isinstance(rest[0], PoseBundlePort):
        pose_bundle_output_port = rest.pop(0)
    if pose_bundle_output_port is not None:
        checked_type(pose_bundle_output_port, PoseBundlePort, 'pose_bundle_output_port')
    if len(rest) > 2:
        raise ArgumentTypeError(f'ConnectDrakeVisualizer: {len(args) + 2} arguments are too many')
    lcm = rest[0] if rest else lcm
    role = checked_type(rest[1] if len(rest) > 1 else role, Role, 'role')
    return DrakeVisualizerPublisher(open_lcm() if lcm is None else lcm, role)


def open_lcm(url: str = '') -> Any:
    """Return an ``lcm.LCM`` for a URL (empty: the library's default).

    Raises GeometryError if the library is not installed or the network cannot be used.
    """
    try:
        import lcm
    except ImportError as error:
        raise GeometryError(
            f"Drake's visualiser takes the library lcm, which cannot be imported ({error}): "
            "pip install lcm, or this package with its extra 'lcm'"
        ) from None
    try:
        return lcm.LCM(url) if url else lcm.LCM()
    except (OSError, RuntimeError) as error:
        raise GeometryError(
            f'LCM cannot be opened at {url or "its default address"}: {error}. Is there a route '
            'for multicast? On one machine: ip link set lo multicast on; '
            'ip route add 224.0.0.0/4 dev lo'
        ) from None


def _publish(lcm: Any, channel: str, message: bytes) -> None:
    """Publish a message with the library lcm, or with pydrake's DrakeLcm."""
    send = lcm.publish if hasattr(lcm, 'publish') else lcm.Publish
    send(channel, message)
