"""Drake's model directives (``*.dmd.yaml``): several model files, welded to one scene.

Each model becomes a source with the scoped name that Drake gives it, and its links become frames
of that source. A weld places a model in the world, or mounts it on the link that carries it. A
model that nothing holds waits for its first pose, unless a directive or its file gives one.
Sources of the meaning: ``model_directives.h`` of Drake, and pydrake's parser as observed.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix
from drake_geom_ros.math.quaternions import AngleAxis
from drake_geom_ros.scene_files.description import (
    FilterDescription,
    GroupDescription,
    Member,
    RobotDescription,
    RobotOptions,
    SceneDescription,
)
from drake_geom_ros.scene_files.directive_names import (
    LinkFrame,
    ScopedFrames,
    namespace_of,
    scoped,
)
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.jointed_links import parts_of
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.scene_files.model_files import read_model
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.robot_parts import RobotParts
from drake_geom_ros.scene_files.schema import check_schema, read_schema
from drake_geom_ros.scene_files.welding import Weld, welded_scene
from drake_geom_ros.scene_files.yaml_text import MAX_BYTES, Document, KeyPath, read_yaml, text_of

_RPY = ('roll', 'pitch', 'yaw')
# Keys of a rotation by its tag; those that a rotation has without a tag are these of !Rpy.
_KEYS = {'!Identity': (), '!Rpy': ('deg',), '!AngleAxis': ('angle_deg', 'axis')}
TAGS = tuple(_KEYS)
_SUFFIX = '.dmd.yaml'
_MOST_NESTED = 32
_KEY = re.compile(rb'^directives[ \t]*:', re.MULTILINE)


def is_directives(data: bytes, file: str) -> bool:
    """Return whether a file holds model directives, by its name or by its key."""
    return file.lower().endswith(_SUFFIX) or _KEY.search(data) is not None


def parse_directives(data: bytes, file: str) -> Document:
    """Return the document of a file; raises SceneFileError if it is not one of directives."""
    document = read_yaml(text_of(data, file), file, tags=TAGS, aliases=True)
    check_schema(document, read_schema('drake_geom_ros.scene_files', 'directives.schema.json'))
    return document


def read_directives(
    data: bytes, file: str, folder: Path, resolver: ResourceResolver, options: RobotOptions
) -> SceneDescription:
    """Return the scene that model directives describe; files in them count from ``folder``.

    Raises SceneFileError, with file, line and key, for a document of another form, a name that is
    missing, ambiguous or there twice, a model file that cannot be read, directives that include
    themselves, and a weld of a link that something else holds.
    """
    assembly = _Assembly(resolver, options)
    assembly.take(parse_directives(data, file), folder, '')
    return assembly.scene(file)


@dataclass
class _Model:
    """A model that was added, and the poses of its free links."""

    robot: RobotDescription
    parts: RobotParts
    poses: dict[Member, LinkFrame] = field(default_factory=dict)


class _Assembly:
    """Models, frames, welds and groups in the order of the directives."""

    def __init__(self, resolver: ResourceResolver, options: RobotOptions):
        self._resolver = resolver
        self._options = options
        self._models: dict[str, _Model] = {}
        self._instances: dict[str, Location] = {}
        self._names = ScopedFrames()
        self._welds: list[Weld] = []
        self._groups: dict[str, tuple[GroupDescription, list[tuple[str, Location]]]] = {}
        self._inside: list[Path] = []

    def take(self, document: Document, folder: Path, namespace: str) -> None:
        """Carry out the directives of a document."""
        handlers = {
            'add_model': self._add_model,
            'add_model_instance': self._add_instance,
            'add_frame': self._add_frame,
            'add_weld': self._add_weld,
            'add_collision_filter_group': self._add_group,
            'add_directives': self._add_directives,
        }
        for index, directive in enumerate(document.value['directives']):
            ((kind, plain),) = directive.items()
            handlers[kind](
                _Directive(document, ('directives', index, kind), plain), folder, namespace
            )

    def scene(self, file: str) -> SceneDescription:
        models = [(model.robot, model.parts) for model in self._models.values()]
        poses = [pose for model in self._models.values() for pose in model.poses.items()]
        free = dict(poses)
        return welded_scene(file, models, self._welds, free, self._all_groups(), self._options)

    def _claim(self, name: str, where: Location) -> None:
        if name in self._instances:
            line = self._instances[name].line
            raise where.error(f'there is a model {name!r} already, see line {line}')
        self._instances[name] = where

    def _add_model(self, entry: '_Directive', folder: Path, namespace: str) -> None:
        name, where = scoped(namespace, entry.plain['name']), entry.at()
        self._claim(name, entry.at('name'))
        path = self._file(entry, folder)
        parts = read_model(path, name, self._resolver, self._options)
        robot = RobotDescription(name, path, RigidTransform(), where=where, tree=parts.tree)
        model = _Model(robot, parts)
        self._models[name] = model
        self._names.add_model(name, parts)
        configuration: dict[str, float] = {}
        for joint, values in entry.plain.get('default_joint_positions', {}).items():
            at = entry.at('default_joint_positions', joint)
            row = values if isinstance(values, list) else [values]
            try:
                configuration |= values_of_drake(parts.tree, joint, row)
            except (ValueError, RuntimeError) as error:
                raise at.error(str(error)) from error
        model.robot = replace(robot, configuration=configuration)
        for link in entry.plain.get('default_free_body_pose', {}):
            key = ('default_free_body_pose', link)
            at = entry.at(*key)
            base = entry.plain['default_free_body_pose'][link].get('base_frame', 'world')
            frame = self._names.find(scoped(name, link or self._only(parts, at)), at)
            X_WF = self._names.find(scoped(namespace, base), at)
            X_WL = X_WF.X_LF @ entry.pose(*key) @ frame.X_LF.inverse()
            model.poses[frame.link] = LinkFrame(X_WF.link, X_WL)

    @staticmethod
    def _only(parts: RobotParts, where: Location) -> str:
        if len(parts.link_names) != 1:
            raise where.error(f'the model has {len(parts.link_names)} links; name one of them')
        return parts.link_names[0]

    def _add_instance(self, entry: '_Directive', folder: Path, namespace: str) -> None:
        self._claim(scoped(namespace, entry.plain['name']), entry.at('name'))

    def _add_frame(self, entry: '_Directive', folder: Path, namespace: str) -> None:
        where = entry.at('X_PF', 'base_frame')
        base = scoped(namespace, entry.plain['X_PF']['base_frame'])
        parent = self._names.find(base, where)
        name = entry.plain['name']
        if not namespace_of(name):
            name = scoped(namespace_of(entry.plain['X_PF']['base_frame']), name)
        X_LF = parent.X_LF @ entry.pose('X_PF')
        frame = LinkFrame(parent.link, X_LF)
        self._names.add(scoped(namespace, name), frame, entry.at('name'))

    def _add_weld(self, entry: '_Directive', folder: Path, namespace: str) -> None:
        ends = (scoped(namespace, entry.plain[end]) for end in ('parent', 'child'))
        P, C = (
            self._names.find(n, entry.at(e))
            for n, e in zip(ends, ('parent', 'child'), strict=True)
        )
        X_LPLC = P.X_LF @ entry.pose('X_PC') @ C.X_LF.inverse()
        self._welds.append(Weld(P.link, C.link, X_LPLC, entry.at()))

    def _add_group(self, entry: '_Directive', folder: Path, namespace: str) -> None:
        plain, where = entry.plain, entry.at()
        inner = scoped(namespace, plain.get('model_namespace', ''))
        name = scoped(inner, plain['name'])
        if name in self._groups:
            raise entry.at('name').error(f'there is a collision filter group {name!r} already')
        members = [
            self._names.link(scoped(inner, member), entry.at('members', index))
            for index, member in enumerate(plain.get('members', ()))
        ]
        ignored = plain.get('ignored_collision_filter_groups', ())
        group = GroupDescription(
            name, tuple(members), tuple(scoped(inner, other) for other in ignored), where
        )
        others = [
            (scoped(inner, other), entry.at('member_groups', index))
            for index, other in enumerate(plain.get('member_groups', ()))
        ]
        self._groups[name] = group, others

    def _add_directives(self, entry: '_Directive', folder: Path, namespace: str) -> None:
        path, where = self._file(entry, folder), entry.at('file')
        if path in self._inside or len(self._inside) == _MOST_NESTED:
            raise where.error(
                f'{path} includes itself, or is nested more than {_MOST_NESTED} deep'
            )
        with path.open('rb') as stream:
            data = stream.read(MAX_BYTES + 1)
        self._inside.append(path)
        inner = scoped(namespace, entry.plain.get('model_namespace', ''))
        self.take(parse_directives(data, str(path)), path.parent, inner)
        self._inside.pop()

    def _file(self, entry: '_Directive', folder: Path) -> Path:
        try:
            return self._resolver.resolve(entry.plain['file'], folder)
        except ValueError as error:
            raise entry.at('file').error(str(error)) from error

    def _all_groups(self) -> list[FilterDescription]:
        """Return the groups, with the members of their member groups."""
        of_models = {
            f.name: f
            for model in self._models.values()
            for f in model.parts.filters
            if isinstance(f, GroupDescription)
        }
        groups = {name: group for name, (group, _) in self._groups.items()} | of_models
        nested = {name: others for name, (_, others) in self._groups.items()}

        def members(name: str) -> dict[Member, None]:
            reached, waiting = {name: None}, [name]
            while waiting:
                for other, place in nested.get(waiting.pop(), ()):
                    if other not in groups:
                        raise place.error(f'there is no collision filter group {other!r}')
                    if other not in reached:
                        reached[other] = None
                        waiting.append(other)
            return dict.fromkeys(member for each in reached for member in groups[each].members)

        return [
            replace(group, members=tuple(members(name)))
            for name, (group, _) in self._groups.items()
        ]


@dataclass(frozen=True)
class _Directive:
    """One directive, with its place in the document."""

    document: Document
    path: tuple[str | int, ...]
    plain: Mapping[str, Any]

    def at(self, *keys: str | int) -> Location:
        return self.document.at(*self.path, *keys)

    def pose(self, *keys: str | int) -> Any:
        return pose_at(self.document, *self.path, *keys)


def pose_at(document: Document, *path: str | int) -> RigidTransform:
    """Return the pose at a key, the identity if it is missing.

    Raises SceneFileError for a tag at another place than the rotation, and for a rotation with
    other keys than its tag has.
    """
    plain = document.value
    for step in path:
        if isinstance(plain, dict) and step not in plain:
            return RigidTransform()
        plain = plain[step]
    for tagged in (path, (*path, 'translation')):
        if tagged in document.tags:
            tag = document.tags[tagged]
            raise document.at(*tagged).error(f'tag {tag}; the rotation alone may have one')
    translation = plain.get('translation', (0.0, 0.0, 0.0))
    return RigidTransform(_rotation(document, plain, (*path, 'rotation')), translation)


def _rotation(document: Document, plain: dict[str, object], path: KeyPath) -> RotationMatrix:
    """Return the rotation of a pose, the identity if it has none."""
    values = plain.get('rotation')
    if values is None:
        return RotationMatrix()
    assert isinstance(values, dict)
    tag = document.tags.get(path, '')
    for inner in ((*path, key) for key in values):
        if inner in document.tags:
            raise document.at(*inner).error(
                f'tag {document.tags[inner]}; only fixed numbers are read'
            )
    if not tag or values.keys() != set(_KEYS[tag]):
        raise document.at(*path).error(
            'must be !Rpy {deg: [roll, pitch, yaw]}, !AngleAxis {angle_deg: ..., axis: [x, y, z]} '
            'or !Identity {}'
        )
    if tag == '!Rpy':
        return RollPitchYaw([math.radians(a) for a in values['deg']]).ToRotationMatrix()
    if tag == '!AngleAxis':
        length = math.hypot(*values['axis'])
        if not length > 0.0:
            raise document.at(*path, 'axis').error('the axis must not be zero')
        axis = [component / length for component in values['axis']]
        return RotationMatrix(theta_lambda=AngleAxis(math.radians(values['angle_deg']), axis))
    return RotationMatrix()


def values_of_drake(tree: LinkTree, joint: str, values: Sequence[float]) -> dict[str, float]:
    """Return values [rad] or [m] by name of a joint, from its position vector in Drake.

    A floating joint has ``qw qx qy qz x y z`` there, a ball joint roll, pitch and yaw. Raises
    ValueError or RuntimeError, which name no line, for a joint that is missing, for another number
    of values, and for a quaternion that is not unit.
    """
    matches = [each for each in tree.joints if each.name == joint]
    if not matches:
        shown = ', '.join(each.name for each in tree.joints) or 'none'
        raise ValueError(f'{tree.name!r} has no joint {joint!r}; there are {shown}')
    kind = matches[0].type
    names = [part.name for part in parts_of(matches[0]) if part.type != 'fixed' and not part.mimic]
    if kind == 'ball':
        names = [f'{joint}/{angle}' for angle in _RPY]
    count = 7 if kind == 'floating' else len(names)
    if len(values) != count:
        raise ValueError(f'{len(values)} values of the {kind} joint {joint!r}; it has {count}')
    if kind != 'floating':
        return dict(zip(names, map(float, values), strict=True))
    w, x, y, z, *position = values
    X = RigidTransform.FromArray([*position, x, y, z, w])
    rpy = X.rotation().ToRollPitchYaw().vector().tolist()
    turned = dict(zip((f'{joint}/{angle}' for angle in _RPY), rpy, strict=True))
    return dict(zip((f'{joint}/{axis}' for axis in 'xyz'), position, strict=True)) | turned
