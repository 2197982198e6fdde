"""Scene description from a YAML document (the format is ``scene.schema.json``)."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from drake_geom_ros.geometry import FilterOperation
from drake_geom_ros.scene_files import srdf
from drake_geom_ros.scene_files.cameras import read_cameras
from drake_geom_ros.scene_files.description import (
    WORLD,
    AwaitedFilter,
    CliqueDescription,
    DeactivationDescription,
    DeclarationDescription,
    FilterDescription,
    FrameDescription,
    GeometryDescription,
    GroupDescription,
    Member,
    RobotDescription,
    RobotOptions,
    SceneDescription,
    Statement,
)
from drake_geom_ros.scene_files.gates import read_gates
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.scene_files.model_files import read_model, read_model_tree
from drake_geom_ros.scene_files.mounting import carried, mount_clique
from drake_geom_ros.scene_files.names import FileNames
from drake_geom_ros.scene_files.obstacle_sources import read_obstacle_sources
from drake_geom_ros.scene_files.proximity_rules import read_proximity_rules
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.robot_files import read_robot_file
from drake_geom_ros.scene_files.schema import check_schema, scene_schema
from drake_geom_ros.scene_files.standing import configuration_of, held_joints_of
from drake_geom_ros.scene_files.yaml_text import Document, KeyPath
from drake_geom_ros.scene_files.yaml_values import (
    Plain,
    paddings_of_robot,
    pose_of,
    roles_of_geometry,
    shape_of,
)

_DEFAULT_NAME = 'scene'
_BLANKS = ' \t'
_NEVER_GONE = {'pose', 'static', 'welded', 'attached_to'}  # keys that say where a frame is
_OF_ATTACHED = {'part_of_robot', 'touch_links'}  # keys of frames with attached_to
# Keys of a robot that change how its URDF is read.
_OF_READING = {'adjacent_links', 'self_collisions', 'solid_meshes', 'padding', 'flat_meshes'}


def parse_scene(document: Document, folder: Path, resolver: ResourceResolver) -> SceneDescription:
    """Return the scene description of a document, and empty that where all of it is read.

    Paths in it count from ``folder``. Raises SceneFileError for a document that violates the
    schema, for values that a pose, a shape or a property refuses, for files that cannot be found
    or read, and for unknown names.
    """
    check_schema(document, scene_schema())
    description = _SceneParser(document, folder, resolver).parse()
    if not description.awaited:  # filters that wait for other sources are read later
        document.free()
    return description


class _SceneParser:
    """Parser of one document's keys, in their order."""

    def __init__(self, document: Document, folder: Path, resolver: ResourceResolver):
        self._document = document
        self._plain: Plain = document.value
        self._folder = folder
        roots = self._plain.get('package_roots', ())
        self._resolver = resolver.looking_in([folder / root for root in roots])
        self._robots: list[RobotDescription] = []
        self._frames: list[FrameDescription] = []
        self._geometries: list[GeometryDescription] = []
        self._filters: list[FilterDescription] = []
        self._warnings: list[str] = []
        self._waiting: list[AwaitedFilter] = []

    def parse(self) -> SceneDescription:
        for index, plain in enumerate(self._plain.get('robots', ())):
            self._read_robot(index, plain)
        for index, plain in enumerate(self._plain.get('frames', ())):
            self._frames.append(self._frame(index, plain))
        for index, plain in enumerate(self._plain.get('geometries', ())):
            self._geometries.append(self._geometry(index, plain))
        names = FileNames(self._frames, self._geometries)
        for index, plain in enumerate(self._plain.get('robots', ())):
            if 'mounted_on' in plain:
                self._mount_robot(index, plain, names)
        for index, plain in enumerate(self._plain.get('frames', ())):
            if {'attached_to', 'mounted_on'} & plain.keys():
                self._hang(index, plain, names)
            if 'gone_after' in plain and (others := _NEVER_GONE & plain.keys()):
                raise self._document.at('frames', index, 'gone_after').error(
                    'gone_after is of frames that messages or TF pose, and that leave with them: '
                    f'leave out {", ".join(sorted(others))}'
                )
            for key in _OF_ATTACHED & plain.keys() if 'attached_to' not in plain else ():
                raise self._document.at('frames', index, key).error(
                    f'{key} is of frames that are attached to another one: give attached_to'
                )
        for index, plain in enumerate(self._plain.get('filters', ())):
            if sources := self._awaited(plain):
                self._await(index, plain, sources)
            else:
                self._filters.append(self._filter(index, plain, names))
        return SceneDescription(
            self._document.file,
            self._sources(),
            tuple(self._robots),
            tuple(self._frames),
            tuple(self._geometries),
            tuple(self._filters),
            read_cameras(self._document, names),
            tuple(self._warnings),
            tuple(self._waiting),
            read_proximity_rules(self._document),
            read_obstacle_sources(self._document),
            read_gates(self._document),
        )

    def _source(self, plain: Plain) -> str:
        name = plain.get('source', self._plain.get('name', _DEFAULT_NAME))
        return str(name).strip(_BLANKS)

    def _sources(self) -> tuple[str, ...]:
        listed = (name.strip(_BLANKS) for name in self._plain.get('sources', ()))
        robots = (robot.name for robot in self._robots)
        users: Iterable[FrameDescription | GeometryDescription] = (
            *self._frames,
            *self._geometries,
        )
        named = (user.source for user in users)
        return tuple(dict.fromkeys((*listed, *robots, *named)))

    def _read_robot(self, index: int, plain: Plain) -> None:
        path = ('robots', index)
        name = plain['name'].strip(_BLANKS)
        where = self._document.at(*path)
        urdf_path = self._file(plain['urdf'], *path, 'urdf')
        srdf_path = self._file(plain['srdf'], *path, 'srdf') if 'srdf' in plain else None
        X_WB = self._pose(plain, *path)
        robot = RobotDescription(
            name,
            urdf=urdf_path,
            X_WB=X_WB,
            srdf=srdf_path,
            where=where,
            joint_states=plain.get('joint_states', ''),
            frame_prefix=plain.get('frame_prefix', ''),
            model=plain.get('model', ''),
        )
        semantics = read_robot_file(srdf_path, self._resolver.is_free) if srdf_path else None
        if plain.get('loaded', False):
            for key in _OF_READING & plain.keys():
                raise self._document.at(*path, key).error(
                    'has no effect with `loaded: true`: geometries and filters are those that '
                    'this file lists'
                )
            tree = read_model_tree(urdf_path, self._resolver, robot.model)
            self._robots.append(self._standing(index, plain, robot, tree, semantics))
            return
        options = RobotOptions(
            plain.get('adjacent_links') != 'kept',
            plain.get('self_collisions') == 'filtered',
            tuple(plain.get('solid_meshes', ())),
            paddings_of_robot(plain.get('padding', {})),
            flat_meshes=_flat_meshes(plain.get('flat_meshes', 0.0)),
        )
        parts = read_model(urdf_path, name, self._resolver, options, robot.model)
        robot = self._standing(index, plain, robot, parts.tree, semantics)
        self._robots.append(robot)
        configuration, parts = robot.configuration, parts.holding(robot.held_joints)
        self._warnings += parts.warnings
        if not {'pose', 'mounted_on'} & plain.keys() and parts.X_WB is not None:
            X_WB = parts.X_WB
            self._robots[-1] = replace(self._robots[-1], X_WB=X_WB)
        if {'pose', 'mounted_on'} & plain.keys() or parts.X_WB is not None:
            try:
                parts = parts.placed(X_WB, configuration)
            except ValueError as error:
                raise self._document.at(*path, 'pose').error(str(error)) from error
        self._frames += parts.frames
        self._geometries += parts.geometries
        self._filters += parts.filters
        if semantics:
            pairs = srdf.read_srdf(*semantics, name, parts.tree.name, parts.link_names, options)
            self._warnings += pairs.warnings
            self._filters += pairs.filters

    def _configuration(
        self, index: int, plain: Plain, tree: LinkTree, semantics: tuple[bytes, str] | None
    ) -> dict[str, float]:
        """Return the initial joint values of a robot; those of a saved scene may exceed limits."""
        if 'configuration' not in plain:
            return {}
        return configuration_of(
            plain['configuration'],
            tree,
            semantics,
            partial(self._document.at, 'robots', index, 'configuration'),
            within_limits=not plain.get('loaded', False),
        )

    def _standing(
        self,
        index: int,
        plain: Plain,
        robot: RobotDescription,
        tree: LinkTree,
        semantics: tuple[bytes, str] | None,
    ) -> RobotDescription:
        """Return a robot with its tree, the first values of its joints, and those that stay."""
        configuration = self._configuration(index, plain, tree, semantics)
        # Of a saved robot passive joints that stay are among the held ones.
        of_passive = None if plain.get('loaded', False) else semantics
        held: dict[str, float] = {}
        if 'held_joints' in plain or of_passive is not None:
            held = held_joints_of(
                plain.get('held_joints', {}),
                tree,
                of_passive,
                configuration,
                partial(self._document.at, 'robots', index, 'held_joints'),
                within_limits=not plain.get('loaded', False),
            )
        joints = {**configuration, **held}
        return replace(
            robot,
            tree=tree,
            configuration=joints,
            held_joints=tuple(held),
            groups=srdf.link_groups(*semantics, tree) if semantics else {},
            virtual_joints=srdf.virtual_joints(*semantics, tree.links) if semantics else {},
        )

    def _frame(self, index: int, plain: Plain) -> FrameDescription:
        path = ('frames', index)
        return FrameDescription(
            self._source(plain),
            plain['name'].strip(_BLANKS),
            plain.get('parent', WORLD).strip(_BLANKS),
            int(plain.get('group', 0)),
            self._pose(plain, *path) if 'pose' in plain else None,
            plain.get('static'),
            self._document.at(*path),
            plain.get('welded', False),
            gone_after=plain.get('gone_after'),
        )

    def _hang(self, index: int, plain: Plain, names: FileNames) -> None:
        """Attach or mount a frame on another one, which may be listed later."""
        k = len(self._frames) - len(self._plain['frames']) + index
        frame = self._frames[k]
        if 'attached_to' in plain:
            to = self._carrier(plain['attached_to'], names, 'frames', index, 'attached_to')
            is_part = plain.get('part_of_robot', True)
            touch_links = tuple(plain.get('touch_links', ()))
            frame = replace(frame, attached_to=to, part_of_robot=is_part, touch_links=touch_links)
        if 'mounted_on' in plain:
            to = self._carrier(plain['mounted_on'], names, 'frames', index, 'mounted_on')
            frame = replace(frame, mounted_on=to)
        self._frames[k] = frame
        if frame.mounted_on and frame.parent != WORLD:
            raise self._document.at('frames', index, 'mounted_on').error(
                f'the frame has the parent {frame.parent!r}, too; leave out one of the two'
            )

    def _carrier(self, plain: Any, names: FileNames, *path: str | int) -> Member:
        """Return the member of the frame that carries another one."""
        where = self._document.at(*path)
        to = names.find(plain, where)
        if to.geometry is not None or to.frame == WORLD:
            raise where.error(f'{plain!r} must be a frame that is not the world')
        return to

    def _mount_robot(self, index: int, plain: Plain, names: FileNames) -> None:
        """Mount the links of a robot on a frame of another source, which may be listed later."""
        path = ('robots', index, 'mounted_on')
        on = self._carrier(plain['mounted_on'], names, *path)
        robot = replace(self._robots[index], mounted_on=on)
        assert robot.tree is not None
        if on.source == robot.name:
            raise self._document.at(*path).error(f'{on.frame!r} is a frame of the robot itself')
        if WORLD in robot.tree.links:
            raise self._document.at(*path).error(
                f'the robot has a link {WORLD!r}, which is the world, so nothing can carry it'
            )
        self._robots[index] = robot
        if plain.get('loaded', False):
            return  # its frames have the key themselves
        self._frames = carried(self._frames, robot, on)
        if plain.get('adjacent_links') != 'kept':
            self._filters += mount_clique(robot, on, self._robots, self._geometries)

    def _geometry(self, index: int, plain: Plain) -> GeometryDescription:
        path = ('geometries', index)
        place = shape_place = self._document.at(*path, 'shape')
        try:
            shape = shape_of(
                plain['shape'],
                lambda uri: str(self._resolver.resolve(uri, self._folder)),
                lambda warning: self._warnings.append(str(shape_place.error(warning))),
            )
            place = self._document.at(*path, 'roles')
            roles = roles_of_geometry(plain, shape)
        except (ValueError, RuntimeError) as error:
            raise place.error(str(error)) from error
        return GeometryDescription(
            self._source(plain),
            plain.get('frame', WORLD).strip(_BLANKS),
            plain['name'].strip(_BLANKS),
            shape,
            self._pose(plain, *path),
            roles,
            self._document.at(*path),
        )

    def _file(self, uri: str, *path: str | int) -> Path:
        try:
            return self._resolver.resolve(uri, self._folder)
        except ValueError as error:
            raise self._document.at(*path).error(str(error)) from error

    def _pose(self, plain: Plain, *path: str | int) -> Any:
        try:
            return pose_of(plain.get('pose'))
        except RuntimeError as error:
            raise self._document.at(*path, 'pose').error(str(error)) from error

    def _awaited(self, plain: Any) -> tuple[str, ...]:
        """Return the awaited sources that names in a filter refer to."""
        awaited = {name.strip(_BLANKS) for name in self._plain.get('awaits', ())}
        sources, waiting = set(), [plain]
        while awaited and waiting:
            part = waiting.pop()
            if isinstance(part, str):
                sources |= {source for source in awaited if part.startswith(f'{source}::')}
            elif isinstance(part, Mapping):
                sources |= awaited & {part.get('source')}
                waiting += part.values()
            else:
                waiting += part
        return tuple(sorted(sources))

    def _await(self, index: int, plain: Plain, sources: tuple[str, ...]) -> None:
        where = self._document.at('filters', index)
        bind = partial(self._filter, index, plain)
        self._waiting.append(AwaitedFilter(sources, plain, where, bind))
        warning = f'waits for {", ".join(map(repr, sources))}; until then it leaves out no pair'
        self._warnings.append(str(where.error(warning)))

    def _filter(self, index: int, plain: Plain, names: FileNames) -> FilterDescription:
        ((kind, value),) = plain.items()
        path = ('filters', index, kind)
        where = self._document.at(*path)
        if kind == 'declaration':
            statements = (
                self._statement(item, (*path, i), names)
                for i, statement in enumerate(value)
                for item in statement.items()
            )
            return DeclarationDescription(tuple(statements), where)
        if kind in ('group', 'clique'):
            name = value['name'].strip(_BLANKS)
            members = self._members(value['members'], (*path, 'members'), names)
            if kind == 'clique':
                return CliqueDescription(name, members, where)
            ignores = tuple(other.strip(_BLANKS) for other in value.get('ignores', ()))
            return GroupDescription(name, members, ignores, where)
        if kind == 'deactivate':
            return DeactivationDescription(self._members(value, path, names), where)
        statement = self._statement((kind, value), path[:-1], names)
        return DeclarationDescription((statement,), where)

    def _statement(self, item: tuple[str, Any], path: KeyPath, names: FileNames) -> Statement:
        kind, value = item
        operation = FilterOperation[kind.upper()]
        if not operation.takes_two_sets:
            return Statement(operation, self._members(value, (*path, kind), names))
        set_a, set_b = (self._members(s, (*path, kind, i), names) for i, s in enumerate(value))
        return Statement(operation, set_a, set_b)

    def _members(
        self, plain: Sequence[Any], path: KeyPath, names: FileNames
    ) -> tuple[Member, ...]:
        return tuple(
            names.find(name, self._document.at(*path, index)) for index, name in enumerate(plain)
        )


def _flat_meshes(plain: str | float | Plain) -> str | float:
    """Return the thickness [m] of flat meshes, or that they are left out."""
    return float(plain['thickness']) if isinstance(plain, Mapping) else plain
