"""Writer of scene descriptions as YAML text, which ``yaml_scene`` reads back."""

from collections.abc import Iterable, Iterator
from typing import Any

import yaml

from drake_geom_ros.proximity_rules import is_zone
from drake_geom_ros.scene_files.cameras import plain_camera
from drake_geom_ros.scene_files.description import (
    WORLD,
    CliqueDescription,
    DeactivationDescription,
    FilterDescription,
    FrameDescription,
    GeometryDescription,
    GroupDescription,
    Member,
    RobotDescription,
    SceneDescription,
    Statement,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.gates import plain_gates
from drake_geom_ros.scene_files.names import FileNames
from drake_geom_ros.scene_files.obstacle_sources import ObstacleSource, plain_obstacle_source
from drake_geom_ros.scene_files.proximity_rules import plain_proximity_rule
from drake_geom_ros.scene_files.yaml_text import (
    MAX_BYTES,
    MOST_ITEMS,
    MOST_VALUES,
    is_text_without_quotes,
)
from drake_geom_ros.scene_files.yaml_values import plain_pose, plain_roles, plain_shape

_NO_WRAP = 2**30


class _Dumper(getattr(yaml, 'CSafeDumper', yaml.SafeDumper)):  # type: ignore[misc]
    """YAML dumper that quotes text unless ``yaml_text`` reads it as the same text without."""


def _represent_text(dumper: Any, text: str) -> Any:
    style = None if is_text_without_quotes(text) else '"'
    return dumper.represent_scalar('tag:yaml.org,2002:str', text, style=style)


_Dumper.add_representer(str, _represent_text)


def to_yaml(description: SceneDescription) -> str:
    """Return the text of a scene: one line for each source, robot, frame, geometry and filter.

    Robots are written with ``loaded: true``, since their links are among the frames and
    geometries. Raises SceneFileError for contents that the format cannot express, such as a
    property that is an object, and for more than the reader accepts.
    """
    names = FileNames(description.frames, description.geometries)
    try:
        sections: dict[str, list[Any]] = {
            'awaits': sorted({s for each in description.awaited for s in each.sources}),
            'sources': list(description.sources),
            'robots': [_robot(robot, names) for robot in description.robots],
            'frames': [_frame(frame, names) for frame in description.frames],
            'geometries': [_geometry(geometry) for geometry in description.geometries],
            'filters': [
                *(_filter(entry, names) for entry in description.filters),
                *(each.plain for each in description.awaited),
            ],
            'cameras': [plain_camera(camera, names) for camera in description.cameras],
            'proximity_rules': [plain_proximity_rule(rule) for rule in description.rules],
        }
        check_size(sections, description.file)
        text = ''.join(_section(key, items) for key, items in sections.items())
        if description.obstacle_sources:
            sensors = {
                each.name: plain_obstacle_source(each) for each in description.obstacle_sources
            }
            lines = ''.join(f'  {name}: {_flow(plain)}' for name, plain in sensors.items())
            text += f'obstacle_sources:\n{lines}'
        if description.gates:
            text += f'gate: {_flow(plain_gates(description.gates))}'
        if (size := len(text.encode(errors='surrogatepass'))) > MAX_BYTES:
            raise SceneFileError(
                f'cannot be saved: its text would have {size} bytes, and {MAX_BYTES} are read; '
                'save meshes as files of their own',
                description.file,
            )
        return text
    except TypeError as error:
        raise SceneFileError(f'cannot be saved: {error}', description.file) from error


def obstacle_source_text(source: ObstacleSource) -> str:
    """Return the keys of a source as they stand in a scene file."""
    return _flow(plain_obstacle_source(source)).strip()


def check_size(plain: Any, file: str) -> None:
    """Raise SceneFileError for longer lists, or more values, than the reader accepts."""
    count, waiting = 0, [plain]
    while waiting:
        part = waiting.pop()
        items = list(part.values()) if isinstance(part, dict) else part
        count += len(items)
        if isinstance(part, list) and len(part) > MOST_ITEMS:
            raise SceneFileError(
                f'cannot be saved: a list of {len(part)} items, and {MOST_ITEMS} are read', file
            )
        if count > MOST_VALUES:
            raise SceneFileError(f'cannot be saved: more than {MOST_VALUES} values', file)
        waiting += [item for item in items if isinstance(item, (dict, list))]


def _section(key: str, items: list[Any]) -> str:
    if not items:
        # The reader refuses empty text, so an empty scene still writes its list of sources.
        return 'sources: []\n' if key == 'sources' else ''
    lines = ''.join(f'- {_flow(item)}' for item in items)
    return f'{key}:\n{lines}'


def _flow(item: Any) -> str:
    text = yaml.dump(
        item,
        Dumper=_Dumper,
        default_flow_style=True,
        allow_unicode=True,
        sort_keys=False,
        width=_NO_WRAP,
    )
    # PyYAML ends a document of one scalar with dots.
    return str(text).removesuffix('...\n')


def _present(**entries: Any) -> dict[str, Any]:
    """Return the entries that are not None."""
    return {key: value for key, value in entries.items() if value is not None}


def _robot(robot: RobotDescription, names: FileNames) -> dict[str, Any]:
    return _present(
        name=robot.name,
        urdf=str(robot.urdf),
        model=robot.model or None,
        srdf=str(robot.srdf) if robot.srdf else None,
        pose=plain_pose(robot.X_WB) or None,
        joint_states=robot.joint_states or None,
        frame_prefix=robot.frame_prefix or None,
        mounted_on=robot.mounted_on and names.name(robot.mounted_on),
        configuration=dict(robot.configuration) or None,
        held_joints={name: robot.configuration[name] for name in robot.held_joints} or None,
        loaded=True,
    )


def _frame(frame: FrameDescription, names: FileNames) -> dict[str, Any]:
    return _present(
        name=frame.name,
        source=frame.source,
        parent=None if frame.parent == WORLD else frame.parent,
        group=frame.group or None,
        pose=None if frame.X_PF is None else plain_pose(frame.X_PF),
        static=frame.static,
        welded=frame.welded or None,
        mounted_on=frame.mounted_on and names.name(frame.mounted_on),
        attached_to=frame.attached_to and names.name(frame.attached_to),
        part_of_robot=None if frame.part_of_robot else False,
        touch_links=list(frame.touch_links) or None,
        gone_after=frame.gone_after,
    )


def _geometry(geometry: GeometryDescription) -> dict[str, Any]:
    return _present(
        name=geometry.name,
        source=geometry.source,
        frame=None if geometry.frame == WORLD else geometry.frame,
        pose=plain_pose(geometry.X_FG) or None,
        shape=plain_shape(geometry.shape),
        sensor=is_zone(geometry.roles) or None,
        roles=plain_roles(geometry.roles),
    )


def _filter(entry: FilterDescription, names: FileNames) -> dict[str, Any]:
    if isinstance(entry, GroupDescription):
        ignores = list(entry.ignores) or None
        members = list(_members(entry.members, names))
        return {'group': _present(name=entry.name, members=members, ignores=ignores)}
    if isinstance(entry, CliqueDescription):
        return {'clique': {'name': entry.name, 'members': list(_members(entry.members, names))}}
    if isinstance(entry, DeactivationDescription):
        return {'deactivate': list(_members(entry.members, names))}
    statements = [_statement(statement, names) for statement in entry.statements]
    return statements[0] if len(statements) == 1 else {'declaration': statements}


def _statement(statement: Statement, names: FileNames) -> dict[str, Any]:
    key = statement.operation.name.lower()
    set_a = list(_members(statement.set_a, names))
    if not statement.operation.takes_two_sets:
        return {key: set_a}
    return {key: [set_a, list(_members(statement.set_b, names))]}


def _members(members: Iterable[Member], names: FileNames) -> Iterator[Any]:
    return (names.name(member) for member in members)
