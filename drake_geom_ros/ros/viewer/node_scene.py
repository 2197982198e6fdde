"""The scene of a running node as a page shows it: from its topics, asked further by services."""

from __future__ import annotations

import threading
import time
from typing import Any

import numpy as np
from drake_geom_msgs import msg
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from visualization_msgs.msg import Marker, MarkerArray

from drake_geom_ros.client import Services
from drake_geom_ros.client.listening import LATCHED
from drake_geom_ros.client.scene_table import carriers_of
from drake_geom_ros.common.counting import counted
from drake_geom_ros.common.geometry_names import GeometryNames
from drake_geom_ros.geometry import CandidatePairs, GeometryError, GeometryId, Role
from drake_geom_ros.live.conversions.fields import pose_from_message
from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.conversions.names import MAPS, some_of
from drake_geom_ros.live.conversions.proximity_rules import rules_from_message
from drake_geom_ros.live.conversions.scene import properties_from_message, role_from_number
from drake_geom_ros.live.conversions.shapes import shape_from_message
from drake_geom_ros.math.batched import matrices_from_poses
from drake_geom_ros.proximity_rules import NamedGeometries, ScenePairs, WatchedPairs
from drake_geom_ros.ros.viewer.node_contacts import NodeContacts
from drake_geom_ros.ros.viewer.node_tables import NodeTables, in_words
from drake_geom_ros.ros.viewer.rival_publishers import RivalPublishers
from drake_geom_ros.viewing.bodies import ShownBody
from drake_geom_ros.viewing.cell_layers import CELL_LAYERS, CellLayer
from drake_geom_ros.viewing.looks import Look, colour_by, is_drawn, solid_by
from drake_geom_ros.viewing.rules import ShownRule, nearest_by_rule
from drake_geom_ros.viewing.shown_contacts import ShownContacts
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.shown_scene import Ghost, ShownGeometries, ShownMoment

_ANSWER_PATIENCE = 2.0  # [s] for who waits at the page
_ASK_PERIOD = 0.2  # [s] between two questions beyond what the node publishes
_LATE = 2.0  # [s] without poses, after which it is said
_NEWEST = QoSProfile(depth=1)
_MARKERS = QoSProfile(depth=10)  # none is to be lost: only layers that changed are sent
# Shapes name files, and this process reads them with the rights of who started it.
_ANY_FILE = ['package://', '/']


class SilentNodeError(GeometryError):
    """The node did not answer in time."""


class NodeScene:
    """Listens with a node that another thread spins; a node that starts anew is followed."""

    def __init__(self, node: Node, server: str = '/scene_graph') -> None:
        self._server = server
        self._lock = threading.RLock()
        self._services = Services(node, server)
        self._contacts = NodeContacts(self._services, server, self._changed)
        self._tables = NodeTables(node, self._services, server, self._changed)
        self._rivals = RivalPublishers(node, [f'{server}/scene', f'{server}/geometry_poses'])
        self._shown_bodies: dict[int, ShownBody] = {}
        self._changes = 0
        self._troubles: list[str] = []
        self._known = -1  # the version of the scene's names
        self._names: dict[int, str] = {}
        self._looks: list[Look] = []
        self._geometries = ShownGeometries(np.zeros(0, np.int64), [], {})
        self._cells: dict[str, CellLayer] = {}  # by namespace of ~/markers
        self._maps = ''  # in words, how many sensed maps there are
        self._poses = np.zeros((0, 3, 3)), np.zeros((0, 3))
        self._ghosts, self._ghosts_heard = list[Ghost](), 0.0
        self._heard = 0.0  # [s] of the steady clock, when poses came
        self._bodies: dict[int, GeometryNames] = {}  # with the proximity role, by id value
        self._rules: Any = None  # the last ProximityStates, and the pairs that it is about
        self._watched: WatchedPairs | None = None
        self._results: Any = None  # of the topic, or of the last answer
        self._asked: tuple[float, str] | None = None  # what the answer is for
        self._answer: Any = None
        self._next = 0.0  # [s] of the steady clock, when it may be asked again
        for kind, topic, take, profile in (
            (msg.Scene, 'scene', self._take_scene, LATCHED),
            (msg.GeometryPoses, 'geometry_poses', self._take_poses, _NEWEST),
            (msg.GeometryPoses, 'stopping_poses', self._take_ways, _NEWEST),
            (msg.SignedDistancePairs, 'signed_distances', self._take_results, _NEWEST),
            (msg.ProximityStates, 'proximity_states', self._take_rules, LATCHED),
            (MarkerArray, 'markers', self._take_markers, _MARKERS),
        ):
            node.create_subscription(kind, f'{server}/{topic}', take, profile)

    # As ShownScene says.

    def version(self) -> object:
        """Return a value that changes with each message, and each second without one."""
        return self._changes, int(time.monotonic() - self._heard)

    def moment(self, max_distance: float, accuracy: str, *, contacts: bool = False) -> ShownMoment:
        """Return where everything is, and the pairs up to a distance [m].

        They are those of the topic as far as these go; farther ones, and those of another
        accuracy than ``exact``, are asked for now and shown when they come. So are contact
        surfaces.
        """
        with self._lock:
            results = self._results
            beyond = results is None or max_distance > results.max_distance
            if beyond or accuracy != 'exact':
                self._ask(max_distance, accuracy)
                results = self._answer if self._asked == (max_distance, accuracy) else results
            R_WGs, p_WGs = self._poses
            pairs = self._pairs(results, max_distance)
            remarks = self._remarks() + self._left_out(results)
            rules = self._shown_rules(pairs)
            shown = ShownContacts.none()
            if contacts:
                shown = self._contacts.shown(self._known, self._names)
                remarks += [*shown.remarks, *shown.missing]
            return ShownMoment(
                self._geometries,
                R_WGs=R_WGs,
                p_WGs=p_WGs,
                pairs=pairs,
                R_WFs=np.zeros((0, 3, 3)),
                p_WFs=np.zeros((0, 3)),
                remarks=remarks,
                rules=rules,
                patches=shown.patches,
                cells=list(self._cells.values()),
                tables=self._tables.shown(),
                ghosts=self._ghosts_of_now(),
            )

    def explain(self, pair: tuple[int, int]) -> list[str]:
        """Return why a pair is not reported; raises GeometryError where the node does not say."""
        a, b = (f'#{value}' for value in pair)
        answer = self._call('explain_filter', geometry_a=a, geometry_b=b)
        return list(answer.reasons)

    def body(self, value: int) -> ShownBody | None:
        """Return a geometry by its id value; None for sensed maps, and for what is not there."""
        with self._lock:
            return self._shown_bodies.get(value)

    def _remarks(self) -> list[str]:
        warning = self._rivals.warning()
        return [warning, *self._state()] if warning else self._state()

    def _state(self) -> list[str]:
        """Return in words what the node sends and what is missing."""
        if self._known < 0:
            return [f'waiting for {self._server}/scene']
        if not self._heard:
            return [f'waiting for {self._server}/geometry_poses']
        age = time.monotonic() - self._heard
        said = [f'poses of {self._server} {age:.1f} s old']
        if age > _LATE:
            said.append('nothing comes: the node may be down; what is seen is of before')
        if self._maps and not self._cells:
            said.append(f'{self._maps}: no markers came; set publish_markers of the node to true')
        return said + self._troubles

    def _left_out(self, results: Any) -> list[str]:
        """Return in words which pairs are not shown; a missing line does not mean free space."""
        if results is None or results.names_version != self._known:
            return []
        frames, pairs = list(results.waiting_frames), int(results.waiting_pairs)
        if not (frames or pairs):
            return []
        return [
            f'NOT COMPLETE: {counted(pairs, "pair")} left out, as frames never had a pose: '
            f'{some_of(frames)}'
        ]

    # Inputs.

    def _take_scene(self, message: msg.Scene) -> None:
        sources = {source.id: source.name for source in message.sources}
        ranks = {value: rank for rank, value in enumerate(sorted(sources))}
        entries = {frame.id: frame for frame in message.frames}
        frames = {frame.id: frame.name for frame in message.frames}
        files = FileAccess(_ANY_FILE)
        names, looks, troubles, shown = {}, [], [], {}
        world, bodies, maps = message.frames[0].id, {}, 0
        for entry in message.geometries:
            frame = frames[entry.frame_id]
            name = f'{sources[entry.source_id]}::{frame}/{entry.name}'
            names[entry.id] = name
            if any(role_from_number(r.role) == Role.kProximity for r in entry.roles):
                bodies[entry.id] = GeometryNames(
                    *(sources[entry.source_id], frame, entry.name, entry.frame_id == world),
                    carriers=carriers_of(entry.frame_id, entries, sources),
                )
            if sources[entry.source_id] == MAPS:
                maps += 1
                continue  # its cells come by ~/markers, and this message has those of before
            try:
                shape = shape_from_message(entry.shape, files)
            except RuntimeError as error:
                troubles.append(f'{name}: {error}')
                continue
            roles = {role_from_number(r.role): properties_from_message(r) for r in entry.roles}
            source = sources[entry.source_id]
            shown[entry.id] = ShownBody(entry.id, name, source, frame, shape, roles)
            for role, properties in roles.items():
                if not is_drawn(properties):
                    continue
                colour = colour_by(properties, role, ranks[entry.source_id], shape)
                solid = solid_by(properties, role)
                looks.append(Look(GeometryId(entry.id), role, name, colour, shape, solid))
        with self._lock:
            self._names, self._looks, self._troubles = names, looks, troubles
            self._shown_bodies = shown
            self._known = message.names_version
            self._maps = f'{counted(maps, "sensed map")} not shown' if maps else ''
            self._geometries = ShownGeometries(np.zeros(0, np.int64), [], names)
            self._poses = np.zeros((0, 3, 3)), np.zeros((0, 3))
            self._results = self._answer = self._asked = None
            self._bodies, self._watched = dict(sorted(bodies.items())), None
            self._changes += 1

    def _take_poses(self, message: msg.GeometryPoses) -> None:
        with self._lock:
            if message.names_version != self._known:
                return
            ids = np.asarray(message.ids).astype(np.int64)
            if not np.array_equal(ids, self._geometries.ids):
                shown = set(ids.tolist())
                looks = [look for look in self._looks if look.geometry.get_value() in shown]
                self._geometries = ShownGeometries(ids, looks, self._names)
            self._poses = matrices_from_poses(np.asarray(message.poses).reshape(-1, 7))
            self._heard = time.monotonic()
            self._changes += 1

    def _take_ways(self, message: msg.GeometryPoses) -> None:
        """Take where bodies are on the way of a stop: each place repeats the ids of bodies."""
        with self._lock:
            self._ghosts, self._ghosts_heard = [], time.monotonic()
            self._changes += 1
            if message.names_version != self._known:
                return
            ids = np.asarray(message.ids).astype(np.int64)
            Rs, ps = matrices_from_poses(np.asarray(message.poses).reshape(-1, 7))
            places = np.cumsum(np.append(True, np.diff(ids) <= 0))[: len(ids)]
            for place in np.unique(places).tolist():
                rows = places == place
                self._ghosts.append(Ghost(ids[rows], Rs[rows], ps[rows]))

    def _ghosts_of_now(self) -> list[Ghost]:
        """Return the ghosts of bodies that are shown, unless they are of a while ago."""
        if time.monotonic() - self._ghosts_heard > _LATE:
            return []
        shown = self._geometries.ids
        return [ghost for ghost in self._ghosts if np.isin(ghost.ids, shown).all()]

    def _take_results(self, message: msg.SignedDistancePairs) -> None:
        with self._lock:
            self._results = message
            self._changes += 1

    def _take_markers(self, message: MarkerArray) -> None:
        """Take the layers of sensed maps, the only ones of these markers that no topic has."""
        with self._lock:
            for marker in message.markers:
                if marker.action == Marker.DELETEALL:
                    self._cells.clear()
                kind, separator, source = marker.ns.partition('::')
                if not separator or kind not in CELL_LAYERS:
                    continue
                self._cells.pop(marker.ns, None)
                if marker.action == Marker.ADD and marker.points:
                    self._cells[marker.ns] = _layer(kind, source, marker)
            self._changes += 1

    def _changed(self) -> None:
        with self._lock:
            self._changes += 1

    def _take_rules(self, message: msg.ProximityStates) -> None:
        with self._lock:
            self._rules, self._watched = message, None
            self._changes += 1

    # Answers.

    def _shown_rules(self, pairs: ReportedPairs) -> list[ShownRule]:
        """Return the states of the rules, each with its nearest pair."""
        message = self._rules
        if message is None or self._known < 0:
            return []
        rules = rules_from_message(message.rules)
        if self._watched is None:
            every = CandidatePairs.of_all(np.array(list(self._bodies), dtype=np.int64))
            names = NamedGeometries(list(self._bodies.values()))
            met = [rule.name for rule in rules]
            self._watched = WatchedPairs(rules, ScenePairs(names, every), met)
        nearest = nearest_by_rule(self._watched, pairs)
        return [
            ShownRule(
                rule.name,
                rule.level,
                message.entered[k],
                _why(message.why[k], message.awaits_acknowledgement[k]) or message.trouble[k],
                nearest.get(k),
            )
            for k, rule in enumerate(rules)
        ]

    def _pairs(self, results: Any, max_distance: float) -> ReportedPairs:
        """Return the pairs of a message, with witnesses where their geometries are shown."""
        if results is None or results.names_version != self._known:
            return ReportedPairs.none()
        ids = np.stack([results.id_a, results.id_b], axis=1).astype(np.int64)
        distance, error_bound = np.asarray(results.distance), np.asarray(results.error_bound)
        near = distance - error_bound <= max_distance  # what may be: see level bound
        there = np.isin(ids, self._geometries.ids).all(axis=1) & near
        rows = np.searchsorted(self._geometries.ids, ids[there])
        R_WGs, p_WGs = self._poses
        p_WCs = []
        for column, flat in enumerate((results.p_aca, results.p_bcb)):
            R, p = R_WGs[rows[:, column]], p_WGs[rows[:, column]]
            p_GC = np.asarray(flat).reshape(-1, 3)[there]
            p_WCs.append(p + np.einsum('kij,kj->ki', R, p_GC))
        normals = np.asarray(results.nhat_ba_w).reshape(-1, 3)[there]
        return ReportedPairs(
            *(ids[there], distance[there], error_bound[there], *p_WCs, normals)
        ).sorted()

    def _ask(self, max_distance: float, accuracy: str) -> None:
        """Request pairs when due; the answer is shown when it arrives."""
        now = time.monotonic()
        name = 'compute_signed_distance_pairwise'
        if now < self._next or self._services.missing(name):
            return
        # Nothing more is asked while an answer is out, unless it got lost.
        self._next = now + _ANSWER_PATIENCE
        future = self._services.send(name, max_distance=max_distance, accuracy=accuracy)

        def take(done: Future) -> None:
            answer = done.result()
            with self._lock:
                self._next = time.monotonic() + _ASK_PERIOD
                if answer is not None and answer.success:
                    self._answer, self._asked = answer.result, (max_distance, accuracy)
                    self._changes += 1

        future.add_done_callback(take)

    def _call(self, name: str, **fields: Any) -> Any:
        """Call a service from a thread that waits; raises GeometryError without an answer."""
        if self._services.missing(name):
            raise SilentNodeError(f'nobody serves {self._server}/{name} now')
        future, came = self._services.send(name, **fields), threading.Event()
        future.add_done_callback(lambda _: came.set())
        if not came.wait(_ANSWER_PATIENCE):
            raise SilentNodeError(
                f'{self._server}/{name} did not answer in {_ANSWER_PATIENCE:g} s'
            )
        answer = future.result()
        if answer is None or not answer.success:
            raise SilentNodeError(f'{name}: {getattr(answer, "message", "no answer")}')
        return answer


def _layer(kind: str, source: str, marker: Marker) -> CellLayer:
    """Return the layer of a marker of cubes."""
    X_WM = pose_from_message(marker.pose)
    p_MCs = np.array([(p.x, p.y, p.z) for p in marker.points])
    colour = marker.color
    return CellLayer(
        source,
        kind,
        X_WM.multiply(p_MCs.T).T,
        X_WM.rotation().ToQuaternionAsVector(),
        marker.scale.x,
        (colour.r, colour.g, colour.b, colour.a),
    )


def _why(number: int, awaits_acknowledgement: bool) -> str:
    why = in_words(number)
    return f'{why}, to be acknowledged' if awaits_acknowledgement else why
