"""Services that only read the scene: the live scene, a request, a response.

They run beside the cycle, in a thread of their own: each takes a view of the scene, which is held
for a moment, and computes on that. RuntimeError refuses; the message of an answer says what it
leaves out.
"""

from __future__ import annotations

import math
from collections import Counter
from math import comb
from typing import Any

import numpy as np

from drake_geom_ros.common.free_memory import free_memory
from drake_geom_ros.geometry import ArgumentError, HalfSpace, Role
from drake_geom_ros.live.conversions.contact_surfaces import fill_contact_surfaces, size_of
from drake_geom_ros.live.conversions.fields import fill_pose, unsigned
from drake_geom_ros.live.conversions.request_types import (
    ContactSurfacesRequest,
    EmptyRequest,
    GetPoseRequest,
    JointNamesRequest,
    OnePairRequest,
    PairwiseRequest,
    PoseAgesRequest,
    QueryRequest,
    StateRequest,
    ToPointRequest,
    TwoGeometriesRequest,
)
from drake_geom_ros.live.conversions.results import (
    CANDIDATE_SIZE,
    PENETRATION_SIZE,
    POINT_DISTANCE_SIZE,
    SIGNED_DISTANCE_SIZE,
    fill_closing_speeds,
    fill_penetrations,
    fill_point_distances,
    fill_signed_distances,
)
from drake_geom_ros.live.scene.clocks import UNKNOWN
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.point_blocks import distances_to
from drake_geom_ros.live.scene.scene_filters import owned_by
from drake_geom_ros.live.scene.scene_view import SceneView

# What an answer takes while it is made and sent: the rows of the query, the arrays of the message,
# the message as rcl takes it, and what goes out.
_COPIES = 5
_SMALL = 1.0  # [MB]: for less nobody looks how much memory is left


def _accuracy(request: QueryRequest) -> str | None:
    return request.accuracy or None


def _limit(name: str, value: float) -> float:
    """Return a distance limit of a request; 0 stands for infinity, as the query's default is."""
    if not value >= 0.0:
        raise ArgumentError(f'{name} is {value}; it must be >= 0 [m], and 0 stands for infinity')
    return value or math.inf


def _require_room(live: LiveScene, rows: int, size: float, instead: str) -> None:
    """Raise ArgumentError for an answer of ``rows`` of ``size`` [bytes] that is too large."""
    if (megabytes := rows * size / 1e6) > live.most_megabytes:
        raise ArgumentError(
            f'an answer of {rows} rows takes {megabytes:.1f} MB, and the parameter '
            f'max_answer_size allows {live.most_megabytes:g} MB: {instead}'
        )
    if megabytes > _SMALL and (left := free_memory() / 1e6) < (needed := _COPIES * megabytes):
        raise ArgumentError(
            f'an answer of {rows} rows takes {needed:.0f} MB of memory until it is sent, and the '
            f'limits of the process leave {left:.0f} MB: {instead}'
        )


def _may_be_large(live: LiveScene, rows: int, size: int) -> bool:
    """Return whether it is worth counting exactly before so many rows, at most, are computed."""
    return rows * size / 1e6 > min(_SMALL, live.most_megabytes)


def _pairs_at_least(view: SceneView) -> int:
    """Return how many pairs, at least, a query without a limit of the distance reports.

    All of them, without those that can never be, that are filtered, or that wait for a pose.
    Planes have no distance from one another; where they are filtered, or wait, they count twice.
    """
    inspector = view.query.inspector()
    geometries = inspector.GetAllGeometryIds(Role.kProximity)
    planes = [g for g in geometries if isinstance(inspector.GetShape(g), HalfSpace)]
    pairs, of_planes = (
        comb(len(those), 2)
        - sum(comb(n, 2) for n in Counter(map(inspector.GetFrameId, those)).values())
        for those in (geometries, planes)
    )
    filtered, waiting = view.filters.num_filtered_pairs(), view.query.num_waiting_pairs()
    return pairs - of_planes - filtered - waiting


def compute_point_pair_penetration(live: LiveScene, request: QueryRequest, response: Any) -> None:
    """Report the pairs that overlap."""
    view = live.view(request.poses, request.joints)
    results = view.query.ComputePointPairPenetration(accuracy=_accuracy(request))
    _require_room(live, len(results), PENETRATION_SIZE, 'filter pairs that always overlap')
    fill_penetrations(response.result, results)
    fill_closing_speeds(response.result, view.closing_speeds(results))
    view.moment.stamp(response.result)
    view.waiting().tell_pairs(response.result)
    response.message = view.reservations_of_list()


def compute_signed_distance_pairwise(
    live: LiveScene, request: PairwiseRequest, response: Any
) -> None:
    """Report the signed distances up to a limit."""
    limit = _limit('max_distance', request.max_distance)
    view = live.view(request.poses, request.joints)
    instead = 'ask with a smaller max_distance, or by compute_signed_distance_pair'
    count = view.query.inspector().NumGeometriesWithRole(Role.kProximity)
    if limit == math.inf and _may_be_large(live, comb(count, 2), SIGNED_DISTANCE_SIZE):
        _require_room(live, _pairs_at_least(view), SIGNED_DISTANCE_SIZE, instead)
    results = view.query.ComputeSignedDistancePairwiseClosestPoints(
        limit, accuracy=_accuracy(request)
    )
    _require_room(live, len(results), SIGNED_DISTANCE_SIZE, instead)
    fill_signed_distances(response.result, results, limit)
    fill_closing_speeds(response.result, view.closing_speeds(results))
    view.moment.stamp(response.result)
    view.waiting().tell_pairs(response.result)
    response.message = view.reservations_of_list()


def compute_signed_distance_pair(live: LiveScene, request: OnePairRequest, response: Any) -> None:
    """Report the signed distance of one pair."""
    view = live.view(request.poses, request.joints)
    a, b = view.names.geometry(request.geometry_a), view.names.geometry(request.geometry_b)
    results = view.query.signed_distance_of_pair(a, b, accuracy=_accuracy(request))
    fill_signed_distances(response.result, results, math.inf)
    fill_closing_speeds(response.result, view.closing_speeds(results))
    view.moment.stamp(response.result)


def compute_signed_distance_to_point(
    live: LiveScene, request: ToPointRequest, response: Any
) -> None:
    """Report the signed distances to points."""
    limit = _limit('threshold', request.threshold)
    points = np.asarray(request.points, dtype=np.float64)
    if points.size % 3:
        raise ArgumentError(
            f'points holds {points.size} numbers; it must hold x y z for each point'
        )
    view = live.view(request.poses, request.joints)
    instead = 'ask for fewer points, or with a smaller threshold'
    count, geometries = points.size // 3, view.query.inspector().GetAllGeometryIds(Role.kProximity)
    if limit == math.inf and _may_be_large(live, count * len(geometries), POINT_DISTANCE_SIZE):
        rows = count * sum(map(view.query.is_placed, geometries))
        _require_room(live, rows, POINT_DISTANCE_SIZE, instead)
    parts, blocks = distances_to(
        view.query,
        points.reshape(-1, 3),
        np.arange(count),
        limit,
        accuracy=_accuracy(request),
    )
    _require_room(live, sum(map(len, parts)), POINT_DISTANCE_SIZE, instead)
    fill_point_distances(response.result, parts, limit, blocks)
    view.moment.stamp(response.result)
    view.waiting().tell_geometries(response.result)
    response.message = view.reservations()


def compute_contact_surfaces(
    live: LiveScene, request: ContactSurfacesRequest, response: Any
) -> None:
    """Report where bodies press each other."""
    view = live.view(request.poses, request.joints)
    query = view.query
    participants = len(query.hydroelastic_geometries())
    if not participants:
        raise ArgumentError(
            'no geometry has hydroelastic properties: give some to the role proximity, in the '
            'group `hydroelastic` (see docs/contact_surfaces.md)'
        )
    contacts = query.contacts(time_budget=live.time_budget, must_stop=live.must_stop)
    if contacts.late() and live.must_stop():
        raise ArgumentError('the node stops: the surfaces were not computed to their end')
    if len(contacts.others) and not request.with_fallback:
        query.refuse_others(contacts)
    rows = len(contacts.surfaces) + len(contacts.others)
    size = size_of(contacts, request.polygons)
    _require_room(live, rows, size / max(rows, 1), 'ask without polygons, or filter pairs')
    fill_contact_surfaces(response.result, contacts, participants, request.polygons)
    view.moment.stamp(response.result)
    view.waiting().tell_pairs(response.result)
    response.message = view.reservations()


def find_collision_candidates(live: LiveScene, request: StateRequest, response: Any) -> None:
    """Report the pairs that bounds alone do not keep apart."""
    view = live.view(request.poses, request.joints)
    ids = view.query.collision_candidates()
    _require_room(live, len(ids), CANDIDATE_SIZE, 'filter pairs that never matter')
    response.id_a, response.id_b = unsigned(ids[:, 0]), unsigned(ids[:, 1])
    _tell(view, response)


def has_collisions(live: LiveScene, request: StateRequest, response: Any) -> None:
    """Report whether any pair overlaps."""
    view = live.view(request.poses, request.joints)
    response.has_collisions = view.query.HasCollisions()
    _tell(view, response)


def _tell(view: SceneView, response: Any) -> None:
    """Say in an answer without a header what it is for, and what it leaves out."""
    response.scene_version = view.moment.version
    view.moment.tell_oldest(response)
    view.waiting().tell_pairs(response)
    response.message = view.reservations()


def get_pose(live: LiveScene, request: GetPoseRequest, response: Any) -> None:
    """Report the live pose of a frame or a geometry."""
    if bool(request.frame) == bool(request.geometry):
        raise ArgumentError('frame and geometry are both given or both empty; give exactly one')
    if request.relative_to not in (0, 1):
        raise ArgumentError(
            f'relative_to is {request.relative_to}; it must be 0 (WORLD) or 1 (PARENT)'
        )
    view = live.view()
    names, query, inspector = view.names, view.query, view.query.inspector()
    world = inspector.world_frame_id()
    if request.frame:
        frame = names.frame(request.frame)
        parent = inspector.GetParentFrame(frame) if request.relative_to else world
        X = query.X_PF(frame) if request.relative_to else query.X_WF(frame)
    else:
        geometry = names.geometry(request.geometry)
        parent = inspector.GetFrameId(geometry) if request.relative_to else world
        X = inspector.GetPoseInFrame(geometry) if request.relative_to else query.X_WG(geometry)
    fill_pose(response.pose.pose, X)
    response.pose.header.frame_id = names.frame_names[parent]
    if view.moment.newest_stamp is not None:
        response.pose.header.stamp = view.moment.newest_stamp


def get_filters(live: LiveScene, request: EmptyRequest, response: Any) -> None:
    """Report the state of the filters."""
    view = live.view()
    manager = view.filters
    response.has_transient_history = manager.has_transient_history()
    active = [f.get_value() for f in manager.active_filter_ids()]
    response.active_filter_ids = unsigned(np.array(active))
    response.active_filter_owners = [view.filter_owners[number] for number in active]
    response.filtered_pairs = manager.num_filtered_pairs()


def explain_filter(live: LiveScene, request: TwoGeometriesRequest, response: Any) -> None:
    """Report whether a pair is filtered, and by which declarations."""
    view = live.view()
    a, b = view.names.geometry(request.geometry_a), view.names.geometry(request.geometry_b)
    named = {
        f'transient declaration {number}': owned_by(owner)
        for number, owner in view.filter_owners.items()
    }
    response.reasons = [reason + named.get(reason, '') for reason in view.filters.explain(a, b)]
    response.filtered = bool(response.reasons)


def get_pose_ages(live: LiveScene, request: PoseAgesRequest, response: Any) -> None:
    """Report the age of the pose of each frame, the oldest first."""
    with live.reading() as scene:
        names, inspector = scene.model.names, scene.model.inspector
        frames = list(dict.fromkeys(map(names.frame, request.frames)))
        if names.world in frames:
            raise ArgumentError('frames holds the world frame, which has no pose')
        frames = frames or list(names.labels)
        ages = scene.poses.ages_by_name()
        waiting = set(scene.query.waiting_frames())
        rows = [
            (
                ages[name := names.frame_names[frame]],
                frame not in waiting,
                name,
                frame.get_value(),
                inspector.GetParentFrame(frame).get_value() * inspector.IsAttached(frame),
            )
            for frame in frames
        ]
    for age, placed, name, value, carrier in sorted(rows, key=lambda row: (-row[0], row[1:3])):
        response.names.append(name)
        response.ids.append(value)
        response.ages.append(age if placed else math.inf)
        response.waiting.append(not placed)
        response.attached_to.append(carrier)


def get_joint_positions(live: LiveScene, request: JointNamesRequest, response: Any) -> None:
    """Report the value, the speed and the age of each joint."""
    with live.reading() as scene:
        robots = scene.model.joints.robots
        places = scene.model.joints.places(request.names)
        if not request.names:
            places = scene.model.joints.every_place()
        age = live.clocks.ages()
        for place in places:
            robot = robots[place.robot]
            value = robot.values[place.column]
            heard = value is not None and value.since != UNKNOWN
            response.names.append(robot.full_names[place.column])
            response.positions.append(math.nan if value is None else value.position)
            response.velocities.append(math.nan if value is None else value.speed)
            response.ages.append(age(value.since) if value is not None and heard else math.inf)
            response.waiting.append(value is None)
