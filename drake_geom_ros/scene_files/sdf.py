"""Models and worlds of SDFormat: each model becomes a source, its links become frames.

Links of nested models are named as in Drake, ``nested::link``. All models stand where the file
puts them; links below a joint that moves wait for its value. Static models are welded to the
world. Only what changes a pair or a distance is read.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from drake_geom_ros.geometry import Mesh, Role
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import sdf_filters, urdf_filters
from drake_geom_ros.scene_files.description import (
    WORLD,
    CliqueDescription,
    FilterDescription,
    FrameDescription,
    GeometryDescription,
    Member,
    RobotOptions,
)
from drake_geom_ros.scene_files.flat_meshes import with_flat_meshes
from drake_geom_ros.scene_files.grounding import free_links, grounded
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.robot_parts import (
    RobotParts,
    is_visual_only,
    visual_only_warning,
)
from drake_geom_ros.scene_files.sdf_elements import pose_in, text_of
from drake_geom_ros.scene_files.sdf_joints import joint_of
from drake_geom_ros.scene_files.sdf_models import MODEL, Item, Scope, read_scope
from drake_geom_ros.scene_files.sdf_poses import link_of, model_pose, pose_of
from drake_geom_ros.scene_files.sdf_shapes import is_extruded, shape_of
from drake_geom_ros.scene_files.sdf_vocabulary import warnings_about
from drake_geom_ros.scene_files.urdf_proximity import proximity_properties_of
from drake_geom_ros.scene_files.urdf_tree import UNDRIVEN, check_forest, root_links
from drake_geom_ros.scene_files.welding import Weld
from drake_geom_ros.scene_files.xml_tree import local_name, prefix_warning

_UNDRIVEN = 'no joint value moves this joint: send poses of {!r}, which waits for the first one'
_NO_SHAPES = 'the model {!r} has no <collision> elements: no query sees anything of it'


@dataclass(frozen=True)
class _Placed:
    """A scope in a model: the prefix of its names, its pose, and whether it is static."""

    prefix: str
    scope: Scope
    X_WM: RigidTransform
    is_static: bool


def read_sdf(
    data: bytes,
    file: str,
    folder: Path,
    resolver: ResourceResolver,
    options: RobotOptions,
    source: str = '',
    model_name: str = '',
) -> tuple[dict[str, RobotParts], list[Weld]]:
    """Return the parts of each model of a file by its name, and the welds between models.

    Paths count from ``folder``.

    With ``source`` only the model of that name is read, or the only one if the name is empty, and
    becomes that source. Raises SceneFileError, with file and line, for

    - text that is not SDFormat up to version 1.12, or has no model;
    - names that are missing or there twice, and poses that count from each other;
    - shapes and joints that are not read, bad numbers, and files that are missing;
    - links that have two parents, or joints in a ring.
    """
    world, files = read_scope(data, file, folder, resolver)
    warnings = tuple(prefix_warning(world.element, file))
    chosen = {n: m for n, m in world.nested.items() if not source or n == (model_name or n)}
    if source and len(chosen) != 1:
        names = ', '.join(world.nested) or 'none'
        wanted = f'no model {model_name!r}' if model_name else 'one model is wanted'
        raise files[0].at(world.element).error(f'{wanted}; there are {names}')
    parts = {}
    for name, model in chosen.items():
        try:
            X_WM = model_pose(world, model)
        except ValueError as error:
            raise model.file.at(model.element).error(str(error)) from error
        reader = _ModelReader(source or name, _Placed('', model, X_WM, model.is_static))
        parts[source or name] = reader.parts(resolver, options)
    first = next(iter(parts))
    warnings += warnings_about([(world, world.element)])
    parts[first] = replace(parts[first], warnings=(*warnings, *parts[first].warnings))
    return parts, [_weld(world, *joint) for joint in world.joints.items()] if not source else []


def _weld(world: Scope, name: str, item: Item) -> Weld:
    """Return the weld of a fixed joint between two models of a world."""
    where = item.file.at(item.element)
    if item.element.get('type') != 'fixed':
        raise where.error('a joint between two models must be fixed; others are not read')
    ends, X_WLs = [], []
    try:
        for end in ('parent', 'child'):
            link = link_of(world, text_of(item.element, end))
            X_WLs.append(pose_of(world, link))
            model, _, inner = link.partition('::')
            ends.append(Member('', WORLD) if link == WORLD else Member(model, inner))
    except ValueError as error:
        raise where.error(str(error)) from error
    return Weld(ends[0], ends[1], X_WLs[0].inverse() @ X_WLs[1], where)


class _ModelReader:
    """Reader of one model with its nested models."""

    def __init__(self, source: str, model: _Placed):
        self._source = source
        self._scopes = list(_below(model))
        self._is_static = model.is_static
        self._X_WLs: dict[str, RigidTransform] = {}
        self._undriven: list[UrdfJoint] = []
        self._links: dict[str, tuple[_Placed, Item]] = {}
        for placed in self._scopes:
            for name, item in placed.scope.links.items():
                self._links[placed.prefix + name] = placed, item
                self._X_WLs[placed.prefix + name] = self._pose(placed, name, item)

    def parts(self, resolver: ResourceResolver, options: RobotOptions) -> RobotParts:
        where = self._scopes[0].scope.file.at(self._scopes[0].scope.element)
        if not self._links:
            raise where.error(f'the model {self._source!r} has no links')
        joints = [*self._joints()]
        check_forest(joints)
        links = (WORLD, *self._links) if any(j.parent == WORLD for j in joints) else self._links
        tree = grounded(LinkTree(self._scopes[0].scope.name, tuple(links), tuple(joints)))
        moved = urdf_filters.moved_links(tree.joints)
        welded = urdf_filters.welded_links(tree.joints, options)
        frames = tuple(
            FrameDescription(
                self._source,
                name,
                static=False if name in moved else None,
                where=item.file.at(item.element),
                welded=name in welded,
            )
            for name, (_, item) in self._links.items()
        )
        masks: dict[Member, int] = {}
        listed = [
            geometry
            for name, (placed, item) in self._links.items()
            for geometry in self._geometries(name, placed, item, resolver, options, masks)
        ]
        geometries, of_flat = with_flat_meshes(listed, options, where)
        members = {Member(self._source, g.frame, g.name) for g in geometries}
        registered = {member: mask for member, mask in masks.items() if member in members}
        shaped = {geometry.frame for geometry in geometries}
        groups, of_groups = self._groups()
        held = (*tree.joints, *self._undriven)
        filters: tuple[FilterDescription, ...] = (
            *urdf_filters.adjacent_cliques(held, shaped, self._source, options),
            *urdf_filters.self_cliques(shaped, self._source, options),
            *self._without_self_collisions(shaped),
            *groups,
            *sdf_filters.bitmask_filters(registered, where),
        )
        elements = [(p.scope, p.scope.element) for p in self._scopes]
        warnings = (*warnings_about(elements), *of_groups, *of_flat)
        warnings += tuple(str(j.where.error(_UNDRIVEN.format(j.child))) for j in self._undriven)
        if not geometries:
            warnings += (str(where.error(_NO_SHAPES.format(self._source))),)
        else:
            elements_of = {name: item.element for name, (_, item) in self._links.items()}
            only_seen = [name for name, link in elements_of.items() if is_visual_only(link)]
            warnings += visual_only_warning(only_seen, len(self._links), where)
        X_WB, free = self._standing(tree)
        return RobotParts(
            frames,
            geometries,
            filters,
            tree,
            warnings,
            dict(self._offsets()),
            X_WB,
            free,
            self._is_static,
        )

    def _standing(self, tree: LinkTree) -> tuple[RigidTransform, dict[str, RigidTransform]]:
        """Return the pose of the root link in the world, and those of links that float."""
        roots = root_links(tree.joints, tree.links)
        if roots != [WORLD]:
            return self._X_WLs[roots[0]], {}
        return RigidTransform(), {link: self._X_WLs[link] for link in free_links(tree)}

    def _pose(self, placed: _Placed, name: str, item: Item) -> RigidTransform:
        """Return the pose of a name of a scope in the world."""
        try:
            return placed.X_WM @ pose_of(placed.scope, name)
        except ValueError as error:
            raise item.file.at(item.element).error(str(error)) from error

    def _joints(self) -> Iterator[UrdfJoint]:
        for placed in self._scopes:
            if placed.is_static:
                for link in placed.scope.links:
                    name = placed.prefix + link
                    where = self._links[name][1].file.at(self._links[name][1].element)
                    X_WL, z = self._X_WLs[name], (0.0, 0.0, 1.0)
                    yield UrdfJoint('fixed', WORLD, name, f'{name}_static', X_WL, z, where=where)
                continue
            for name, item in placed.scope.joints.items():
                try:
                    joint = self._joint(placed, name, item)
                except (ValueError, RuntimeError) as error:
                    raise item.file.at(item.element).error(str(error)) from error
                if joint.type == UNDRIVEN:
                    self._undriven.append(joint)
                else:
                    yield joint

    def _joint(self, placed: _Placed, name: str, item: Item) -> UrdfJoint:
        scope, ends, frames = placed.scope, [], []
        for end in ('parent', 'child'):
            links = [text_of(child) for child in item.element if local_name(child) == end]
            if len(links) != 1 or not links[0]:
                raise ValueError(f'<joint> has {len(links)} <{end}>; it has one')
            frames.append(item.base if links[0] == MODEL else links[0])
            link = link_of(scope, frames[-1])
            ends.append(link if link == WORLD else placed.prefix + link)
        parent, child = ends
        if child == WORLD or parent == child:
            raise ValueError(f'the child {child!r} must be a link other than the parent')
        X_WJ = self._pose(placed, name, item)
        X_WP = RigidTransform() if parent == WORLD else self._X_WLs[parent]
        X_JC = X_WJ.inverse() @ self._X_WLs[child]
        stays = item.X.IsExactlyIdentity() and item.relative_to in ('', child)
        if stays and placed.prefix + text_of(item.element, 'child') == child:
            X_WJ, X_JC = self._X_WLs[child], RigidTransform()
        X_PJ = X_WP.inverse() @ X_WJ
        if local_name(item.element) != str(item.element.tag):
            # Drake's own joints move the child frame in the parent frame, wherever links stand.
            X_WPf, X_WCf = (placed.X_WM @ pose_of(scope, name) for name in frames)
            X_PJ, X_JC = X_WP.inverse() @ X_WPf, X_WCf.inverse() @ self._X_WLs[child]

        def frame(other: str) -> RigidTransform:
            E = item.base if other == MODEL else other
            return X_WJ.inverse() @ placed.X_WM @ pose_of(scope, E)

        return joint_of(
            item.element,
            item.file,
            placed.prefix + name,
            (parent, child),
            X_PJ,
            X_JC,
            frame,
        )

    def _geometries(
        self,
        link: str,
        placed: _Placed,
        item: Item,
        resolver: ResourceResolver,
        options: RobotOptions,
        masks: dict[Member, int],
    ) -> Iterator[GeometryDescription]:
        names: set[str] = set()
        for index, element in enumerate(item.element.findall('collision')):
            where = item.file.at(element)
            try:
                made = shape_of(element.find('geometry'), item.file, resolver)
                if made is None:
                    continue
                X_LG = self._pose_on_link(link, placed, item, element) @ made[1]
                properties = proximity_properties_of(element)
                mask = sdf_filters.bitmask_of(element)
            except (ValueError, RuntimeError) as error:
                raise where.error(str(error)) from error
            name = (element.get('name') or '').strip(' \t')
            if not name or name in names:
                name = f'{name or "collision"}_{index}'
            names.add(name)
            is_solid = options.is_solid(link, name) or is_extruded(element.find('geometry'))
            if isinstance(made[0], Mesh) and is_solid:
                properties.AddProperty('mesh', 'solid', True)
            if padding := options.padding(link, name):
                properties.AddProperty('proximity', 'padding', padding)
            masks[Member(self._source, link, name)] = mask
            roles = {Role.kProximity: properties}
            yield GeometryDescription(self._source, link, name, made[0], X_LG, roles, where)

    def _pose_on_link(
        self, link: str, placed: _Placed, item: Item, element: Any
    ) -> RigidTransform:
        """Return the pose of a collision element on its link."""
        X, relative_to = pose_in(element)
        if not relative_to:
            return X
        E = item.base if relative_to == MODEL else relative_to
        X_WE = placed.X_WM @ pose_of(placed.scope, E)
        return self._X_WLs[link].inverse() @ X_WE @ X

    def _groups(self) -> tuple[list[Any], list[str]]:
        items = [
            (placed.prefix, item)
            for placed in self._scopes
            for item in placed.scope.others
            if local_name(item.element) == 'collision_filter_group'
        ]
        return sdf_filters.read_groups(items, self._links, self._source)

    def _without_self_collisions(self, shaped: set[str]) -> Iterator[CliqueDescription]:
        """Yield the clique of a model whose ``<self_collide>`` is false."""
        for placed in self._scopes:
            for item in placed.scope.others:
                if local_name(item.element) == 'self_collide' and text_of(item.element) in (
                    'false',
                    '0',
                ):
                    links = [link for link in self._links if link.startswith(placed.prefix)]
                    members = tuple(Member(self._source, k) for k in links if k in shaped)
                    where = item.file.at(item.element)
                    name = f'{self._source}: {placed.prefix}self_collide'
                    yield CliqueDescription(name, members, where)

    def _offsets(self) -> Iterator[tuple[str, tuple[str, RigidTransform]]]:
        """Yield the frames of the model, each with its link and its pose in it."""
        for placed in self._scopes:
            frames = {**placed.scope.frames}
            for name in (*frames, MODEL):
                link = link_of(placed.scope, name)
                full = link if link == WORLD else placed.prefix + link
                X_WF = placed.X_WM @ pose_of(placed.scope, name)
                X_WL = RigidTransform() if link == WORLD else self._X_WLs[full]
                yield placed.prefix + name, (full, X_WL.inverse() @ X_WF)


def _below(model: _Placed) -> Iterator[_Placed]:
    """Yield a model and the models nested in it."""
    yield model
    for name, nested in model.scope.nested.items():
        try:
            X_WM = model.X_WM @ model_pose(model.scope, nested)
        except ValueError as error:
            raise nested.file.at(nested.element).error(str(error)) from error
        is_static = model.is_static or nested.is_static
        yield from _below(_Placed(f'{model.prefix}{name}::', nested, X_WM, is_static))
