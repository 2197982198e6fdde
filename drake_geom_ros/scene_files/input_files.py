"""Input files of a scene besides its own, which no output may overwrite."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from urllib.parse import unquote

from drake_geom_ros.geometry import Convex, Mesh, Role, SceneGraph
from drake_geom_ros.scene_files.description import RobotDescription

_TEXTURE = ('phong', 'diffuse_map')
_MATERIALS = re.compile(rb'^[ \t]*mtllib[ \t]+(.+?)[ \t\r]*$', re.MULTILINE)
# The image is the last word of its line, after options.
_IMAGES = re.compile(
    rb'^[ \t]*(?:map_\w+|bump|disp|decal|norm|refl)[ \t]+(?:.*[ \t])?(\S+)[ \t\r]*$',
    re.MULTILINE | re.IGNORECASE,
)


def files_of(scene_graph: SceneGraph, robots: Iterable[RobotDescription]) -> Iterator[Path]:
    """Yield the URDF and SRDF files of the robots, mesh files, and the files that these name."""
    for robot in robots:
        yield from filter(None, (robot.urdf, robot.srdf))
    inspector = scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds():
        shape = inspector.GetShape(geometry)
        if isinstance(shape, Convex | Mesh) and shape.source().is_path():
            yield shape.source().path()
            yield from _named_in(shape.source().path())
        for role in (Role.kPerception, Role.kIllustration):
            properties = inspector.GetProperties(geometry, role)
            if properties is not None and properties.HasProperty(*_TEXTURE):
                yield Path(str(properties.GetProperty(*_TEXTURE)))


def _named_in(mesh: Path) -> Iterator[Path]:
    """Yield the existing files with materials, images and buffers of a mesh file.

    Faulty files are skipped here; the readers of meshes report their faults.
    """
    suffix = mesh.suffix.lower()
    try:
        if suffix == '.obj':
            names = [_text(name) for name in _MATERIALS.findall(mesh.read_bytes())]
            names.append(mesh.with_suffix('.png').name)  # its image if it has no materials
        elif suffix == '.gltf':
            names = _uris_of(json.loads(mesh.read_bytes()))
        else:
            return
    except (OSError, ValueError):
        return
    for name in dict.fromkeys(names):
        file = mesh.parent / name
        if file.is_file():
            yield file
            if suffix == '.obj' and file.suffix.lower() == '.mtl':
                images = map(_text, _IMAGES.findall(file.read_bytes()))
                yield from filter(Path.is_file, (mesh.parent / image for image in images))


def _text(name: bytes) -> str:
    return name.decode(errors='replace')


def _uris_of(document: object) -> list[str]:
    """Return the files that a glTF document names for its buffers and images."""
    tables = document if isinstance(document, dict) else {}
    lists = [tables.get(key) for key in ('buffers', 'images')]
    entries = [each for some in lists if isinstance(some, list) for each in some]
    entries = [entry for entry in entries if isinstance(entry, dict)]
    uris = [entry['uri'] for entry in entries if isinstance(entry.get('uri'), str)]
    return [unquote(uri) for uri in uris if not uri.startswith('data:')]
