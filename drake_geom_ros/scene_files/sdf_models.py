"""Models and worlds of SDFormat as scopes of named elements, with includes read.

A scope holds the links, frames, joints and nested models that names in it may refer to. An include
becomes a nested model; one with ``merge="true"`` adds its elements to the model that includes it.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.sdf_elements import SdfFile, flag_in, pose_in, text_of
from drake_geom_ros.scene_files.xml_tree import attribute, local_name, read_xml, root_tag

MODEL = '__model__'
_MOST_NESTED = 32
_LATEST = (1, 12)
_RESERVED = re.compile(r'__.*__')


@dataclass(frozen=True)
class Item:
    """A link, frame or joint in a scope.

    Names in it that are empty or ``__model__`` mean the frame ``base`` of the scope.
    """

    element: Any
    file: SdfFile
    X: RigidTransform
    relative_to: str
    base: str = MODEL


@dataclass
class Scope:
    """A model or a world; X is its pose, given in ``relative_to`` of the enclosing scope.

    The pose is that of the model's frame ``placement_frame``. ``proxies`` are the model frames of
    merged includes: the pose of each, the frame that it counts from, and its canonical link.
    """

    name: str
    element: Any
    file: SdfFile
    X: RigidTransform = field(default_factory=RigidTransform)
    relative_to: str = ''
    placement_frame: str = ''
    is_static: bool = False
    is_world: bool = False
    links: dict[str, Item] = field(default_factory=dict)
    frames: dict[str, Item] = field(default_factory=dict)
    joints: dict[str, Item] = field(default_factory=dict)
    nested: dict[str, 'Scope'] = field(default_factory=dict)
    proxies: dict[str, 'Scope'] = field(default_factory=dict)
    others: list[Item] = field(default_factory=list)

    def names(self) -> Iterator[str]:
        """Yield the names in the scope."""
        for group in (self.links, self.frames, self.joints, self.nested, self.proxies):
            yield from group


def read_scope(
    data: bytes, file: str, folder: Path, resolver: ResourceResolver
) -> tuple[Scope, tuple[SdfFile, ...]]:
    """Return a scope with the models of a file or of its world, and the files that were read.

    Raises SceneFileError for a file that is not SDFormat, several worlds, and names that are
    missing, reserved or there twice.
    """
    reader = _Reader(resolver)
    root, sdf = reader.root(data, file, folder)
    worlds = root.findall('world')
    if len(worlds) > 1:
        raise sdf.at(worlds[1]).error('a second <world>; a scene is one')
    if not worlds and root.find('model') is None:
        raise sdf.at(root).error('there is neither a <model> nor a <world>')
    scope = Scope('', root, sdf, is_world=True)
    for element in (root, *worlds):
        reader.fill(scope, element, sdf, MODEL, 0)
    return scope, tuple(reader.files)


class _Reader:
    """Reader of scopes, which keeps the files that it has opened."""

    def __init__(self, resolver: ResourceResolver):
        self._resolver = resolver
        self.files: list[SdfFile] = []

    def root(self, data: bytes, file: str, folder: Path) -> tuple[Any, SdfFile]:
        """Return the root element of a file and its record."""
        root = read_xml(data, file, 'sdf')
        text = root.get('version', '')
        if not re.fullmatch(r'1\.\d{1,2}', text):
            reason = f'version {text!r}; known are 1.2 to {_LATEST[0]}.{_LATEST[1]}'
            raise SceneFileError(reason, file, root.sourceline)
        version = tuple(map(int, text.split('.')))
        if version > _LATEST:
            reason = f'version {text}; known are those up to {_LATEST[0]}.{_LATEST[1]}'
            raise SceneFileError(reason, file, root.sourceline)
        self.files.append(SdfFile(file, folder, version))
        return root, self.files[-1]

    def fill(self, scope: Scope, element: Any, file: SdfFile, base: str, depth: int) -> None:
        """Add the named children of a model, a world or a root element to a scope."""
        for child in element:
            tag = local_name(child)
            where = file.at(child)
            try:
                if tag in ('link', 'frame', 'joint'):
                    X, relative_to = pose_in(child)
                    item = Item(child, file, X, relative_to, base)
                    group = {'link': scope.links, 'frame': scope.frames}.get(tag, scope.joints)
                    group[self._name(scope, child, file)] = item
                elif tag == 'model':
                    nested = self._model(child, file, depth + 1)
                    scope.nested[self._name(scope, child, file)] = nested
                elif tag == 'include':
                    self._include(scope, child, file, depth + 1)
                elif tag not in ('world', 'pose'):
                    scope.others.append(Item(child, file, RigidTransform(), '', base))
            except ValueError as error:
                raise where.error(str(error)) from error

    def _name(self, scope: Scope, element: Any, file: SdfFile, name: str = '') -> str:
        name = name or attribute(element, 'name', file.name)
        if _RESERVED.fullmatch(name) or name == 'world' or '::' in name:
            raise file.at(element).error(f'the name {name!r} is reserved')
        if name in scope.names():
            raise file.at(element).error(f'{name!r} is the name of two elements of its model')
        return name

    def _model(self, element: Any, file: SdfFile, depth: int) -> Scope:
        """Return the scope of a model element."""
        if depth > _MOST_NESTED:
            raise file.at(element).error(f'models are nested more than {_MOST_NESTED} deep')
        X, relative_to = pose_in(element)
        name = attribute(element, 'name', file.name)
        scope = Scope(name, element, file, X, relative_to)
        scope.placement_frame = element.get('placement_frame', '')
        scope.is_static = flag_in(element, 'static')
        self.fill(scope, element, file, MODEL, depth)
        return scope

    def _include(self, scope: Scope, element: Any, file: SdfFile, depth: int) -> None:
        """Add the model that an include names to a scope."""
        uri = text_of(element, 'uri')
        if not uri:
            raise ValueError('<include> has no <uri>')
        path = self._resolver.model_file(uri, file.folder)
        data = path.read_bytes()
        if (tag := root_tag(data)) != 'sdf':
            raise ValueError(f'{path} is no SDF but <{tag}>; add it by a scene file or directives')
        if depth > _MOST_NESTED:
            raise ValueError(f'{path} includes itself')
        root, included = self.root(data, str(path), path.parent)
        models = root.findall('model')
        if len(models) != 1 or root.find('world') is not None:
            raise ValueError(f'{path} has {len(models)} models; an included file has one')
        model = self._model(models[0], included, depth)
        model.name = text_of(element, 'name') or model.name
        if element.find('pose') is not None:
            model.X, model.relative_to = pose_in(element)
        model.placement_frame = text_of(element, 'placement_frame') or model.placement_frame
        if element.find('static') is not None:
            model.is_static = flag_in(element, 'static')
        if element.get('merge', 'false').lower() in ('true', '1'):
            self._merge(scope, model, models[0], included, depth)
        else:
            scope.nested[self._name(scope, element, file, model.name)] = model

    def _merge(self, scope: Scope, model: Scope, element: Any, file: SdfFile, depth: int) -> None:
        """Add the elements of an included model to a scope, below a frame for the model's own."""
        proxy = f'_merged__{model.name}{MODEL}'
        self.fill(scope, element, file, proxy, depth)
        scope.proxies[proxy] = model
