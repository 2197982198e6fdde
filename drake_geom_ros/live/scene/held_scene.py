"""The live scene while it is held: what may be seen of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import (
    ArgumentError,
    FilterId,
    FrameId,
    GeometryId,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
    SceneGraphInspector,
    SourceId,
    closing_speeds,
)
from drake_geom_ros.live.conversions.frame_poses import FramePosesReader, ListedFrames, ReadPoses
from drake_geom_ros.live.conversions.names import NameTable, some_of
from drake_geom_ros.live.scene.awaited_filters import AwaitedFilters
from drake_geom_ros.live.scene.camera_limits import CameraLimits
from drake_geom_ros.live.scene.clocks import Clocks, Since
from drake_geom_ros.live.scene.feeders import JOINTS, MESSAGES, TF, Feeders
from drake_geom_ros.live.scene.half_spaces import overlapping_half_spaces
from drake_geom_ros.live.scene.leases import Leases
from drake_geom_ros.live.scene.out_of_sight import MapSights, Sight
from drake_geom_ros.live.scene.pose_ages import PoseAges, UnknownAges
from drake_geom_ros.live.scene.pose_history import PoseHistory
from drake_geom_ros.live.scene.robot_joints import RobotJoints
from drake_geom_ros.live.scene.scene_rules import Blind, SceneRules
from drake_geom_ros.live.scene.scene_snapshot import MAPS, SceneMark, SceneSnapshot
from drake_geom_ros.live.scene.scene_view import SceneStamp, SceneView
from drake_geom_ros.live.scene.seen_shells import NO_SHELL, BesideBodies, SeenShell, beside_bodies
from drake_geom_ros.live.scene.sender_troubles import clock_troubles, sender_troubles
from drake_geom_ros.live.scene.senders import Joint, Senders, links_of
from drake_geom_ros.live.scene.twists import FrameTwists
from drake_geom_ros.live.scene.waiting import Waiting, waiting
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import (
    CameraDescription,
    RobotDescription,
    SceneDescription,
    add_renderers,
)
from drake_geom_ros.sensed_maps import Cells

_REMEMBERED = 5.0  # [s] for which a pose is told of that was left out
# Frames and geometries; of 1000 each the tables that a change makes anew take some 50 ms.
_MANY = 1000


class SeenMap(NamedTuple):
    """A sensed map of the scene, and the cells that it holds; None before the first message."""

    frame: FrameId
    geometry: GeometryId
    cells: Cells | None
    shell: SeenShell = NO_SHELL
    feeds: tuple[tuple[str, Since], ...] = ()  # sensors, and since when what each showed holds
    sights: tuple[Sight, ...] = ()  # of each of them


class HeldScene:
    """A SceneGraph and a context that shares its model, and what a node must know besides.

    ``LiveScene`` hands it out for the length of a ``with`` block, in which no other thread has it;
    it is not kept for longer.
    """

    def __init__(
        self, scene_graph: SceneGraph, clocks: Clocks, world_frame: str, version: int
    ) -> None:
        """``clocks`` measure the ages of poses; ``version`` is that of an empty scene."""
        self.world_frame = world_frame
        self._clocks = clocks
        self._longest_gap: float | None = None
        self._joints = RobotJoints((), {})
        self._adopt(scene_graph, shared_context(scene_graph), version)
        self.told: list[str] = []  # what is to be logged, by who has a logger
        self.warned: list[str] = []  # what is to be logged as a warning, each once
        # Called when an answer is to name the scene, whose names must be told then.
        self.tell_named: Callable[[HeldScene], object] = lambda _: None
        self.moved = set[int]()  # frames that were posed since the robots on them followed
        # Called with the id values (n,) of frames and the poses (n, 7) that came for them.
        self.keep_rows: Callable[[NDArray[np.int64], NDArray[np.float64]], object] | None = None
        # Where frames were, if somebody has to know.
        self.history: PoseHistory | None = None
        self.filters_per_owner: float = math.inf  # transient ones that an owner may have
        self.camera_limits = CameraLimits()
        self.rules = SceneRules()  # they outlive a scene that is replaced
        self.replaced = 0  # how often another scene, or other sources, took the place of these
        # Called where the sensed maps that topics feed have gone, to have them there again.
        self.stand_maps: Callable[[Any], object] | None = None
        # The distance [m] to bodies from which on a map that a topic feeds has what is there.
        self.told_apart: Callable[[str], float] = lambda name: 0.0

    def _adopt(self, scene_graph: SceneGraph, context: SceneGraphContext, version: int) -> None:
        """Make ``scene_graph`` the scene, with a context that shares it."""
        self._scene_graph, self._context = scene_graph, context
        self.query: QueryObject = scene_graph.get_query_output_port().Eval(self._context)  # live
        self._version_base = version
        self._named_version = -1
        self._ages, self._leases = PoseAges(self._clocks), Leases(self._clocks.steady)
        self.feeders, self.senders = Feeders(self._clocks.steady), Senders(self._clocks.steady)
        self._robots: list[RobotDescription] = []
        self.awaited = AwaitedFilters()
        self.maps_source: SourceId | None = None  # None: there is no map
        self.maps: dict[str, SeenMap] = {}  # by name, of that source
        self.map_changes = 0  # versions that nothing but their cells differ in
        # By name: the frame that a camera is on, and what it is.
        self._cameras: dict[str, tuple[FrameId, CameraDescription]] = {}
        self._owners: dict[int, str] = {}
        self._long_filters: set[int] = set()  # transient ones about many geometries
        # Attached frames by the value of their id, when [s] a pose of one was left out last.
        self._attached: tuple[int, frozenset[int]] = (-1, frozenset())
        self._left_out: dict[int, float] = {}
        self._twists: FrameTwists | None = None
        if self._longest_gap is not None:
            self._twists = FrameTwists(self._longest_gap, self._clocks)

    @property
    def version(self) -> int:
        """The version of the scene: it grows with every change of sources, frames, geometries."""
        return self._version_base + self._scene_graph.model_version()

    @property
    def model_version(self) -> int:
        """The version since which at most the cells of sensed maps changed."""
        return self.version - self.map_changes

    @property
    def names_version(self) -> int:
        """The version since which nothing came or went, and names and roles are the same."""
        return self._version_base + self._scene_graph.names_version()

    def bind_rules(self) -> None:
        """Have the proximity rules be about the scene as it is now."""
        self.rules.bind(self.query, self.names_version)

    @property
    def accuracy(self) -> str:
        """The accuracy level of queries that name none."""
        return self._scene_graph.default_accuracy()

    @property
    def inspector(self) -> SceneGraphInspector:
        """The inspector of the scene."""
        return self._scene_graph.model_inspector()

    @property
    def names(self) -> NameTable:
        """The names of this version of the scene."""
        self._refresh()
        return self._names

    @property
    def cameras(self) -> dict[str, tuple[FrameId, CameraDescription]]:
        """The cameras by name, each with its frame; a copy."""
        return dict(self._cameras)

    def camera(self, name: str) -> tuple[FrameId, CameraDescription]:
        """Return the frame of a camera and what it is; raises ArgumentError for none."""
        if name not in self._cameras:
            raise ArgumentError(
                f'There is no camera {name[:80]!r}{nearest(name, self._cameras)}. Cameras: '
                f'{some_of(list(self._cameras)) or "none"}. See list_cameras.'
            )
        return self._cameras[name]

    def owned_geometry(self, name: str) -> tuple[SourceId, GeometryId]:
        """Return the source that owns a geometry, and the geometry of that name."""
        geometry = self.names.geometry(name)
        return self.inspector.GetOwningSourceId(geometry), geometry

    @property
    def attached(self) -> frozenset[int]:
        """The frames that are attached to others, by the values of their ids."""
        if self._attached[0] != self.names_version:
            self._attached = self.names_version, attached_in(self.inspector)
        return self._attached[1]

    def refuse_maps(self, source: SourceId) -> None:
        """Raise ArgumentError for the source of sensed maps, which only messages change."""
        if source == self.maps_source:
            raise ArgumentError(
                f'the source {MAPS!r} holds sensed maps, which only messages of sensors, '
                'load_obstacles and clear_obstacles change; for what is to stand beside them '
                'register a source of another name'
            )

    def is_mounted(self, frame: FrameId) -> bool:
        """Return whether the home of a frame is one of another source."""
        inspector = self.inspector
        home = inspector.GetHomeFrame(frame)
        owner = inspector.GetOwningSourceId(frame)
        return home != self.names.world and owner != inspector.GetOwningSourceId(home)

    def read_poses(self, message: Any) -> ReadPoses:
        """Return the poses of a FramePoses; raises RuntimeError for what cannot be taken."""
        self._refresh()
        return self._reader.read(message)

    def listed_in(self, message: Any) -> ListedFrames:
        """Return which frames a FramePoses names; raises RuntimeError as ``read_poses``."""
        self._refresh()
        return self._reader.listed_in(message)

    def _refresh(self) -> None:
        if self._named_version != self.model_version:
            prefixes = {robot.name: robot.frame_prefix for robot in self._robots}
            self._names = NameTable(
                self.inspector, self.world_frame, prefixes, maps=self.maps_source
            )
            self._reader = FramePosesReader(self._names)
            frames = {label: frame for frame, label in self._names.labels.items()}
            self._joints = RobotJoints(self._robots, frames, self._joints)
            self._named_version = self.model_version

    def pose_ages(self) -> dict[str, float]:
        """Return the age [s] of the pose of every frame by name; inf for one that is unknown."""
        return self._ages.by_name(self.names)

    def unknown_ages(self) -> UnknownAges:
        """Return the frames that were not posed since the node's clock jumped."""
        return UnknownAges(self._ages.unknown(self.names))

    def posed_since(self, frame: FrameId) -> Since | None:
        """Return since when a frame has its pose; None where it waits, or nobody knows."""
        return self._ages.since(frame.get_value())

    @property
    def clocks(self) -> Clocks:
        """The node's time and steady time."""
        return self._clocks

    def blind_frames(self, stale_after: float) -> Blind:
        """Return the frames whose poses are older [s], never came, or are not to be trusted."""
        absent = {frame.get_value() for frame in self.query.waiting_frames()}
        stale = self._ages.older_than(stale_after, self.names)
        return Blind(stale, absent, self.contested_frames(), self._ages.of_other_clocks())

    def links_of_stale_joints(self, seconds: float, named: Collection[Joint]) -> set[int]:
        """Return the links of joints whose values are older [s], but for those ``named``."""
        robots, age = self.joints.robots.values(), self._clocks.ages()
        values = ((r.name, k, value) for r in robots for k, value in enumerate(r.values))
        old = {(n, k) for n, k, value in values if value and age(value.since) > seconds}
        return links_of(robots, old.difference(named))

    def contested_frames(self) -> set[int]:
        """Return the frames, by the values of their ids, that two senders pose in turn."""
        contested = self.senders.contested_frames().union(self.feeders.contested())
        if joints := self.senders.contested_joints():
            contested |= links_of(self.joints.robots.values(), joints)
        return contested

    def lag(self) -> float:
        """Return how far [s] behind the poses that were taken last the node is."""
        return self._ages.lag()

    def moment(self) -> SceneStamp:
        """Return which scene and poses an answer of now is for."""
        self.tell_named(self)
        oldest = self._ages.oldest(self.names)
        stamp = self._ages.newest_stamp
        return SceneStamp(self.version, self.names_version, stamp, oldest, self.world_frame)

    @property
    def joints(self) -> RobotJoints:
        """The joints of the robots of this version of the scene, and what is known of them."""
        self._refresh()
        return self._joints

    @property
    def robots(self) -> list[RobotDescription]:
        """The robots, in the order in which they came; a copy."""
        return list(self._robots)

    @property
    def is_large(self) -> bool:
        """True if making all tables of the scene takes longer than a cycle may wait."""
        return is_large(self.inspector)

    def robot_names(self) -> set[str]:
        """Return the sources of the robots."""
        return {robot.name for robot in self._robots}

    @property
    def newest_stamp(self) -> Any:
        """The newest stamp of a pose, a builtin_interfaces/Time; None before the first."""
        return self._ages.newest_stamp

    @property
    def watches_motion(self) -> bool:
        """True if twists of frames are kept."""
        return self._twists is not None

    def watch_motion(self, longest_gap: float) -> None:
        """Keep the twists of frames from now on: see ``FrameTwists``."""
        self._longest_gap = longest_gap
        self._twists = FrameTwists(longest_gap, self._clocks)
        # Of no pair at all: what it takes is there now, and not in the first cycle only.
        none = self.query.ComputeSignedDistancePairwiseClosestPoints(-math.inf)
        closing_speeds(none, self.twists() or {})

    def twists(self) -> dict[FrameId, NDArray[np.float64]] | None:
        """Return the twists V_WF (6,) of now of the frames that have one; None: nobody watches."""
        if self._twists is None:
            return None
        return self._twists.in_world(self.query, self._ages.static())

    def tell_effects(self, *, detailed: bool) -> None:
        """Let queries measure the seconds of the cache apart, which costs them microseconds."""
        self._context.set_detailed_effects(detailed)

    def filter_owners(self) -> dict[int, str]:
        """Return who asked for each active transient filter, by its id; empty: nobody said."""
        manager = self._scene_graph.collision_filter_manager()
        active = [filter_id.get_value() for filter_id in manager.active_filter_ids()]
        # Those of filters that are gone are forgotten here.
        self._owners = {number: self._owners.get(number, '') for number in active}
        self._long_filters.intersection_update(active)
        return dict(self._owners)

    def owner_of(self, filter_id: FilterId) -> str:
        """Return who asked for a transient filter; empty: nobody said, or there is no such one."""
        return self._owners.get(filter_id.get_value(), '') if filter_id.is_valid() else ''

    def is_short(self, filter_id: FilterId) -> bool:
        """Return whether a transient filter is soon removed, in a large scene too."""
        return not filter_id.is_valid() or filter_id.get_value() not in self._long_filters

    def filter_leases(self) -> dict[int, float]:
        """Return how long each transient filter with a lease still has it [s], by its id."""
        return {each.get_value(): left for each, left in self._leases.left().items()}

    def waiting(self) -> Waiting:
        """Return what waits for its first pose."""
        return waiting(self.query, self.names, self.beside_bodies())

    def shells(self) -> list[tuple[GeometryId, SeenShell]]:
        """Return what sensors saw beside bodies, by the map that lacks it."""
        maps = self.maps.values()
        return [(each.geometry, each.shell) for each in maps if len(each.shell.centres)]

    def finer_than_maps(self, rule: str = '') -> list[str]:
        """Return in words which rules, or whether this one, are finer than maps can resolve."""
        limits = {
            each.geometry: max(self.told_apart(name), each.cells.resolution if each.cells else 0.0)
            for name, each in self.maps.items()
        }
        return self.rules.finer_than(limits, rule)

    def map_sights(self) -> list[MapSights]:
        """Return where sensors can see, of the maps that these feed."""
        return [(each.geometry, each.sights) for each in self.maps.values() if each.sights]

    def _unseen(self) -> str:
        sights = self.map_sights()
        if sights and self.rules.rules:
            self.bind_rules()  # its bodies must be those of the query
            return self.rules.unseen(self.query, sights)
        return ''

    def beside_bodies(self) -> BesideBodies:
        """Return how many points were seen beside bodies, and how near."""
        return beside_bodies(each.shell for each in self.maps.values())

    def troubles(self) -> list[str]:
        """Return what is wrong with the poses and twists that come, and with lists, in words."""
        values = self.feeders.contested()
        names = [n for frame, n in self.names.frame_names.items() if frame.get_value() in values]
        troubles = [] if self._twists is None else self._twists.troubles(self.names)
        rules = self.rules.troubles(watches_motion=self.watches_motion)
        rules += [*self.finer_than_maps(), *filter(None, [self._unseen()])]
        troubles += self.sender_troubles()
        troubles = [*troubles, *self._told_of_attached(), *self.awaited.troubles(), *rules]
        troubles += filter(None, [overlapping_half_spaces(self.query, self.names)])
        if not names:
            return troubles
        return [
            *troubles,
            f'{counted(len(names), "frame")} {are(len(names))} posed by two of {TF}, '
            f'{MESSAGES} and {JOINTS} in turn, and the last one counts: {some_of(names)}; '
            'stop one of the two',
        ]

    def sender_troubles(self) -> list[str]:
        """Return what is wrong with who sends poses and with their clocks, in words."""
        troubles = sender_troubles(self.senders, self.joints, self.names)
        return troubles + clock_troubles(self._ages.of_other_clocks(), self.names)

    def _told_of_attached(self) -> list[str]:
        """Return which attached frames somebody goes on posing, in words."""
        now = self._clocks.steady()
        posed = {v for v, at in self._left_out.items() if now - at < _REMEMBERED} & self.attached
        names = [n for f, n in self.names.frame_names.items() if f.get_value() in posed]
        if not names:
            return []
        return [
            f'poses of {counted(len(names), "attached frame")} are left out: {some_of(names)}; '
            'what holds a frame says where it is, until detach'
        ]

    def view(self, *, moving: bool = False, stale_after: float = math.inf) -> SceneView:
        """Return a snapshot, which may be kept; ``moving``: with the twists of now.

        It names the poses that are older than ``stale_after`` [s].
        """
        context = self._context.what_if()
        filters = self._scene_graph.collision_filter_manager(context)
        owners = self.filter_owners()
        twists = self.twists() if moving else None
        parts = self.moment(), owners, self.unknown_ages(), self.joints.entries, twists
        beside = self.beside_bodies()
        stale = self._ages.stale(stale_after)
        return SceneView(context, filters, self.names, *parts, beside, stale)

    def copy(self) -> SceneGraphContext:
        """Return a copy that may be kept and changed."""
        return self._context.copy()

    def snapshot(self) -> SceneSnapshot:
        """Return a copy to be described, which takes long and needs no scene."""
        now = {name: robot.configuration() for name, robot in self.joints.robots.items()}
        robots = [replace(r, configuration=now.get(r.name, r.configuration)) for r in self._robots]
        return SceneSnapshot(
            self._context.what_if(),
            self.mark(),
            tuple(robots),
            self._ages.static(),
            self.awaited.waiting(),
            self.rules.rules,
            self.maps_source,
        )

    def mark(self) -> SceneMark:
        """Return what a description of the scene as it is now is of."""
        return SceneMark(
            self.model_version,
            self.inspector.candidate_pairs(),
            tuple(self._scene_graph.collision_filter_manager().active_filter_ids()),
            self.cameras,
            self.awaited.all(),
        )

    def moved_since(self, before: SceneSnapshot) -> dict[tuple[str, str], RigidTransform]:
        """Return X_PF by source and name of the frames that are elsewhere than before.

        Those of sensed maps are left out, which stand where they were seen.
        """
        frames = [frame for frame in self.names.labels if frame not in self.names.of_maps]
        ids = np.array([frame.get_value() for frame in frames], dtype=np.int64)
        R_WFs, p_WFs, is_placed = self._context.X_WFs(ids)
        R_was, p_was, was_placed = before.context.X_WFs(ids)
        moved = (R_WFs != R_was).any(axis=(1, 2)) | (p_WFs != p_was).any(axis=1)
        rows = np.flatnonzero(is_placed & (moved | ~was_placed)).tolist()
        return {self.names.labels[frames[k]]: self.query.X_PF(frames[k]) for k in rows}

    def description(self) -> SceneDescription:
        """Return the scene as it is now; see ``SceneSnapshot.description``."""
        return self.snapshot().description()


def shared_context(scene_graph: SceneGraph) -> SceneGraphContext:
    """Return a context for a live scene, whose frames may wait for their first poses."""
    add_renderers(scene_graph)
    return scene_graph.CreateSharedContext(partial=True)


def is_large(inspector: SceneGraphInspector) -> bool:
    """Return whether tables of all that there is take longer than a cycle may wait."""
    return inspector.num_geometries() + inspector.num_frames() > _MANY


def attached_in(inspector: SceneGraphInspector) -> frozenset[int]:
    """Return the frames that are attached to others, by the values of their ids."""
    frames = [frame for frame in inspector.GetAllFrameIds() if inspector.IsAttached(frame)]
    return frozenset(frame.get_value() for frame in frames)
