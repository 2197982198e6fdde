"""Tracked bodies that come, take another shape, or go."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import NamedTuple

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    IllustrationProperties,
    ProximityProperties,
    Rgba,
    SceneGraph,
    SceneGraphContext,
    Shape,
    SourceId,
    Sphere,
)
from drake_geom_ros.live.conversions.names import HEARTBEAT, TRACKED
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.scene_tracked import (
    NAMED_AS_TRACKED,
    Heartbeat,
    TrackedBody,
)
from drake_geom_ros.math import RigidTransform

BODY = 'body'  # the geometry of each
_COLOUR = Rgba(0.95, 0.6, 0.1, 1.0)


class _Made(NamedTuple):
    """The heartbeat and the new bodies."""

    heartbeat: Heartbeat
    bodies: dict[str, tuple[FrameId, GeometryId]]


def tracked_update(
    scene: HeldScene,
    shapes: Mapping[str, Shape],
    gone: Collection[str] = (),
    then: Callable[[HeldScene], object] = lambda scene: None,
) -> Change[HeldScene, None]:
    """Return a change after which bodies have ``shapes``, and others are ``gone``.

    Bodies that are not there are registered, with the source and its heartbeat where these are
    not there either. ``then`` is called with the changed scene, before anybody else has it.
    Raises ArgumentError where the scene has a source of its own that is called as theirs.
    """
    tracked, inspector, replaced = scene.tracked, scene.model.inspector, scene.replaced
    heartbeat, before = tracked.heartbeat, dict(tracked.bodies)
    others = map(inspector.GetName, inspector.GetAllSourceIds())
    if heartbeat is None and TRACKED in others:
        raise ArgumentError(NAMED_AS_TRACKED)
    leaving = {name: before[name] for name in gone if name in before}
    new = {name: shape for name, shape in shapes.items() if name not in before or name in leaving}
    reshaped = {
        name: shape
        for name, shape in shapes.items()
        if name not in new and before[name].shape != shape
    }

    def first(scene: HeldScene) -> None:
        if scene.replaced != replaced or scene.tracked.heartbeat != heartbeat:
            raise ArgumentError('the scene was replaced while the message was taken')

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> _Made:
        beats = heartbeat or _heartbeat(graph, context)
        for body in leaving.values():
            graph.RemoveFrame(context=context, source_id=beats.source, frame_id=body.frame)
        for name, shape in reshaped.items():
            graph.ChangeShape(
                context=context,
                source_id=beats.source,
                geometry_id=before[name].geometry,
                shape=shape,
            )
        made = {name: _body(graph, context, beats.source, name, s) for name, s in new.items()}
        return _Made(beats, made)

    def end(scene: HeldScene, made: _Made) -> None:
        scene.forget_frames([body.frame for body in leaving.values()])
        tracked.heartbeat = made.heartbeat
        bodies = {name: body for name, body in tracked.bodies.items() if name not in leaving}
        for name, shape in reshaped.items():
            bodies[name] = bodies[name]._replace(shape=shape)
        for name, (frame, geometry) in made.bodies.items():
            bodies[name] = TrackedBody(frame, geometry, new[name])
        tracked.change_to(bodies)
        tracked.kinds.update(map(type, new.values()), map(type, reshaped.values()))
        then(scene)

    is_same = heartbeat is not None and not (leaving or new)
    return Change(on, first, end, same_content=is_same)


def _heartbeat(graph: SceneGraph, context: SceneGraphContext | None) -> Heartbeat:
    """Register the source of tracked bodies with its heartbeat, in no pair and no picture."""
    source = graph.RegisterSource(context=context, name=TRACKED)
    frame = graph.RegisterFrame(context=context, source_id=source, frame=GeometryFrame(HEARTBEAT))
    instance = GeometryInstance(RigidTransform(), Sphere(0.1), HEARTBEAT)
    proximity = ProximityProperties()
    proximity.AddProperty('renderer', 'accepting', '')
    instance.set_proximity_properties(proximity)
    geometry = graph.RegisterGeometry(
        context=context, source_id=source, frame_id=frame, geometry=instance
    )
    graph.collision_filter_manager(context).Deactivate(GeometrySet(geometry))
    return Heartbeat(source, frame, geometry)


def _body(
    graph: SceneGraph,
    context: SceneGraphContext | None,
    source: SourceId,
    name: str,
    shape: Shape,
) -> tuple[FrameId, GeometryId]:
    """Register a body: a frame of its name with one geometry."""
    frame = graph.RegisterFrame(context=context, source_id=source, frame=GeometryFrame(name))
    instance = GeometryInstance(RigidTransform(), shape, BODY)
    instance.set_proximity_properties(ProximityProperties())
    illustration = IllustrationProperties()
    illustration.AddProperty('phong', 'diffuse', _COLOUR)
    instance.set_illustration_properties(illustration)
    geometry = graph.RegisterGeometry(
        context=context, source_id=source, frame_id=frame, geometry=instance
    )
    return frame, geometry
