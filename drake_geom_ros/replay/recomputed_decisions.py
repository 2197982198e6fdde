"""Recomputation of the decision of a recorded proximity event, from the poses in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryId,
    HalfSpace,
    SceneGraph,
    Shape,
    SignedDistanceResults,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import matrices_from_poses
from drake_geom_ros.proximity_rules import Why, named_zones, properties_of_zone
from drake_geom_ros.replay.recorded_events import RecordedEvent
from drake_geom_ros.scene_files import SceneFileError, load_scene

# Events hold unit quaternions, while rotation matrices were used: the difference is a few
# roundings of coordinates of poses and nearest points.
_ROUNDING = 64.0 * float(np.finfo(np.float64).eps)


class Finding(Enum):
    """Result of recomputing a decision."""

    FOUNDED = 'founded'  # the recorded numbers justify the decision
    UNFOUNDED = 'UNFOUNDED'
    NOT_TO_BE_TOLD = 'not to be told'  # the event has nothing that could be recomputed


@dataclass(frozen=True)
class Verdict:
    """Verdict on an event, with the recomputed distance of its pair if it has one."""

    finding: Finding
    because: str
    distance: float | None = None  # [m] at level exact
    error_bound: float | None = None  # [m]


class Judge:
    """Judge of the events of one scene.

    >>> ball = '{shape: {type: sphere, radius: 0.1}, name: ball, frame: '
    >>> judge = Judge(f'''
    ... frames: [{{name: a, pose: {{}}}}, {{name: b, pose: {{position: [1, 0, 0]}}}}]
    ... geometries: [{ball}a}}, {ball}b}}]
    ... ''')
    >>> pose = np.array([0.0, 0, 0, 0, 0, 0, 1])
    >>> event = RecordedEvent(
    ...     1, 'exact', 1, 'hands off', True, Why.NEAR, 'scene::a/ball', 'scene::b/ball',
    ...     0.1, 1e-15, pose, pose + [0.3, 0, 0, 0, 0, 0, 0], np.nan, 0.2, 0.0, 0.0
    ... )
    >>> judge.verdict(event).finding
    <Finding.FOUNDED: 'founded'>
    """

    def __init__(self, scene: str | Path) -> None:
        """Load a scene from a file or text; raises SceneFileError if that fails."""
        graph = SceneGraph()
        loaded = load_scene(scene, graph)
        names = {f'{s}::{f}/{g}': id for (s, f, g), id in loaded.geometries.items()}
        self._take(graph, names, str(scene) if isinstance(scene, Path) else '<text>')

    @classmethod
    def of(cls, graph: SceneGraph, geometries: Mapping[str, GeometryId]) -> Judge:
        """Return the judge of a scene graph, with its geometries by full names."""
        judge = cls.__new__(cls)
        judge._take(graph, geometries, '<scene>')
        return judge

    def _take(self, graph: SceneGraph, names: Mapping[str, GeometryId], file: str) -> None:
        self._graph, self._file = graph, file
        self._geometries = {**names, **named_zones(graph.model_inspector())}

    def verdict(self, event: RecordedEvent) -> Verdict:
        """Return whether the decision of an event was founded.

        Raises SceneFileError if the scene lacks the pair.
        """
        if event.why == Why.GONE:
            return _untold('the rule was removed, or what it is about')
        if event.entered and event.why == Why.NO_POSE:
            return _untold('a pose never came, and what never came is not recorded')
        if event.entered and event.why in (Why.TWO_SENDERS, Why.OTHER_CLOCK):
            return _untold('an event does not record who sent a pose, nor the stamps of its clock')
        if event.why == Why.CANNOT_STOP:
            return _untold('an event does not record the speeds of joints, which braking needs')
        if event.entered and event.why == Why.STALE:
            is_old = event.oldest_pose_age > event.limit_time
            age = f'the oldest pose was {event.oldest_pose_age:.3g} s old'
            return _verdict(is_old, f'{age}, and stale from {event.limit_time:.3g} s on')
        if not event.has_pair:
            if not event.entered and event.distance == np.inf:
                return _untold('no pair was near enough to be looked at')
            return Verdict(Finding.UNFOUNDED, 'it names no pair')
        return self._of_pair(event)

    def _of_pair(self, event: RecordedEvent) -> Verdict:
        names = event.geometry_a, event.geometry_b
        if all(isinstance(self._shape(name), HalfSpace) for name in names):
            return _untold('two half spaces have no distance that could be computed again')
        results = self._distance(event)
        d, bound = float(results.distance[0]), float(results.error_bound[0])
        coordinates = (results.p_WCa, results.p_WCb, event.pose_a[:3], event.pose_b[:3])
        slack = _ROUNDING * (1.0 + max(float(np.abs(each).max()) for each in coordinates))
        if not abs(event.distance - d) <= event.error_bound + bound + slack:
            then = f'the pair was {event.distance!r} m apart ± {event.error_bound:.1e} m, it says'
            now = f'at its poses these are {d!r} m apart ± {bound:.1e} m'
            return Verdict(Finding.UNFOUNDED, f'{then}; {now}', d, bound)
        lower = event.distance - event.error_bound
        reason = _reason(event, lower)
        if reason.finding == Finding.FOUNDED and event.entered and event.why == Why.NEAR:
            early = d - bound - event.limit_distance
            if early > slack:  # justified by a certified bound that is not tight
                reason = Verdict(reason.finding, f'{reason.because}; early by {early:.3g} m')
        return Verdict(reason.finding, reason.because, d, bound)

    def _distance(self, event: RecordedEvent) -> SignedDistanceResults:
        """Return the signed distance of the event's pair at its poses, at level exact."""
        inspector, graph = self._graph.model_inspector(), SceneGraph()
        source, X_WFs, ids = graph.RegisterSource('pair'), {}, []
        for end, name in enumerate((event.geometry_a, event.geometry_b)):
            instance = inspector.CloneGeometryInstance(self._geometry(name))
            instance.set_pose(RigidTransform())
            illustration = instance.illustration_properties()
            if instance.proximity_properties() is None and illustration is not None:
                instance.set_proximity_properties(properties_of_zone(illustration))
            frame = graph.RegisterFrame(source, GeometryFrame(f'{end}'))
            ids.append(graph.RegisterGeometry(source, frame, instance))
            Rs, ps = matrices_from_poses((event.pose_a, event.pose_b)[end][None])
            X_WFs[frame] = RigidTransform(np.vstack([np.c_[Rs[0], ps[0]], [0.0, 0.0, 0.0, 1.0]]))
        context = graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector(X_WFs))
        query = graph.get_query_output_port().Eval(context)
        return query.signed_distance_of_pair(ids[0], ids[1], accuracy='exact')

    def _shape(self, name: str) -> Shape:
        return self._graph.model_inspector().GetShape(self._geometry(name))

    def _geometry(self, name: str) -> GeometryId:
        if name not in self._geometries:
            raise SceneFileError(
                f"the scene has no geometry '{name}' with the proximity role, of which an event "
                'tells; take the scene as it was saved at the scene_version of the event',
                self._file,
            )
        return self._geometries[name]


def _reason(event: RecordedEvent, lower: float) -> Verdict:
    """Return whether the lower bound [m] of an event justifies its decision."""
    limit, speed = event.limit_distance, event.closing_speed
    bound = f'lower bound {lower:.6g} m'
    is_soon, in_time = False, ''
    if event.limit_time > 0.0 and speed > 0.0:
        seconds = max(lower, 0.0) / speed
        is_soon = seconds < event.limit_time
        in_time = f', contact in {seconds:.3g} s of {event.limit_time:.3g} s'
    if not event.entered:
        return _verdict(lower >= limit and not is_soon, f'{bound}, leave {limit:.6g} m{in_time}')
    if event.why == Why.SOON:
        return _verdict(is_soon, f'{bound}{in_time or ", and it was not closing"}')
    return _verdict(lower < limit, f'{bound}, enter {limit:.6g} m')


def _verdict(is_founded: bool, because: str) -> Verdict:
    return Verdict(Finding.FOUNDED if is_founded else Finding.UNFOUNDED, because)


def _untold(because: str) -> Verdict:
    return Verdict(Finding.NOT_TO_BE_TOLD, because)
