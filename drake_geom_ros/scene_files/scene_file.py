"""Reading, loading and saving of scene files."""

import os
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path

from drake_geom_ros.common.stand_ins import stand_in
from drake_geom_ros.geometry import FrameId, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    CameraDescription,
    RobotDescription,
    RobotOptions,
    SceneDescription,
)
from drake_geom_ros.scene_files.directives import is_directives, read_directives
from drake_geom_ros.scene_files.errors import SceneFileError, unreadable
from drake_geom_ros.scene_files.gates import gates_left_out
from drake_geom_ros.scene_files.mesh_scenes import is_mesh_file, mesh_scene
from drake_geom_ros.scene_files.model_files import robot_name
from drake_geom_ros.scene_files.moveit_scene import SUFFIX, read_moveit_scene
from drake_geom_ros.scene_files.mujoco_models import read_mjcf
from drake_geom_ros.scene_files.obstacle_sources import sensors_left_out
from drake_geom_ros.scene_files.registration import LoadedScene, register
from drake_geom_ros.scene_files.resources import ResourceResolver, Roots
from drake_geom_ros.scene_files.robot_files import read_robot_file
from drake_geom_ros.scene_files.robot_parts import RobotParts
from drake_geom_ros.scene_files.saving import describe
from drake_geom_ros.scene_files.sdf import read_sdf
from drake_geom_ros.scene_files.srdf import link_groups, read_srdf, virtual_joints
from drake_geom_ros.scene_files.urdf import read_urdf
from drake_geom_ros.scene_files.welding import Weld, welded_scene
from drake_geom_ros.scene_files.xml_tree import is_xml, root_tag
from drake_geom_ros.scene_files.yaml_scene import parse_scene
from drake_geom_ros.scene_files.yaml_text import MAX_BYTES, MOST_ITEMS, read_yaml, text_of
from drake_geom_ros.scene_files.yaml_writer import to_yaml

PathLike = str | os.PathLike[str]

FORMATS = ('yaml', 'urdf', 'sdf', 'mjcf', 'dmd', 'mesh', 'moveit')
_XML_FORMATS = ('urdf', 'sdf', 'mjcf')
_XML_SUFFIXES = ('.urdf', '.sdf', '.world')
_NO_OPTIONS = RobotOptions()
TEXT = '<text>'  # the name of a text in errors and warnings


def read_scene(
    path_or_text: PathLike,
    format: str = '',
    srdf: PathLike = '',
    package_roots: Roots = (),
    allowed_roots: Roots | None = None,
    options: RobotOptions = _NO_OPTIONS,
    text_name: str = TEXT,
) -> SceneDescription:
    r"""Return the description of a scene file, without registering it.

    A URDF alone is a scene of one robot at the world's origin, with the robot's own name. Files
    with macros are expanded if PyPI's ``xacro`` is installed, unless there are ``allowed_roots``.

    Args:
        path_or_text: A path, or the text itself: a str with a line break in it, or one that
            begins with ``{`` or ``<``. Paths in a text count from the working folder.
        format: ``yaml``, ``urdf``, ``sdf``, ``mjcf`` (by the package mujoco), ``dmd`` (model
            directives), ``mesh`` (a scene of one body) or ``moveit`` (MoveIt's text format). If
            empty, the suffix of a mesh and ``.scene`` decide, and for other files the content:
            the root element of XML, and the key ``directives`` of YAML.
        srdf: The SRDF of a URDF, a path or a text too.
        package_roots: A folder or several to search for packages, see ``ResourceResolver``.
        allowed_roots: A folder or several outside of which no file may be opened.
        options: Options of a model (in YAML each robot has its own); adjacent links are filtered
            by default.
        text_name: The name of a text in errors and warnings.

    Raises:
        SceneFileError: The file is invalid; the error names file, line and key.

    >>> scene = read_scene('geometries:\n- {name: floor, shape: {type: half_space}}')
    >>> scene.geometries[0].source
    'scene'
    """
    text = _as_text(path_or_text)
    resolver = ResourceResolver(package_roots, allowed_roots)
    file = text_name if text else os.fspath(path_or_text)
    if format not in ('', *FORMATS):
        raise SceneFileError(f'format {format!r} must be one of {FORMATS}', file)
    if format == 'mesh' or (not text and not format and is_mesh_file(path_or_text)):
        if text or srdf:
            raise SceneFileError('a mesh is a file, and has no SRDF', file)
        return mesh_scene(Path(path_or_text), options)
    data, folder = _content(path_or_text)
    looks_like_xml = is_xml(data) or (not text and file.lower().endswith(_XML_SUFFIXES))
    if format in _XML_FORMATS or (not format and looks_like_xml):
        path = None if text else Path(file).absolute()
        if path is not None:
            data, file = read_robot_file(Path(file), resolver.is_free)
        if format == 'urdf' or root_tag(data) not in ('sdf', 'mujoco'):
            return _urdf_scene(data, file, folder, path, srdf, resolver, options)
        if srdf:
            raise SceneFileError(f'srdf is only for a URDF, this is <{root_tag(data)}>', file)
        return _models_scene(data, file, folder, path, resolver, options)
    if not text and (reason := stand_in(data)):
        raise SceneFileError(reason, file)
    if srdf:
        raise SceneFileError('srdf is only for a URDF; in YAML a robot has the key `srdf`', file)
    if format == 'moveit' or (not format and not text and file.endswith(SUFFIX)):
        return read_moveit_scene(text_of(data, file), file)
    if format == 'dmd' or (not format and is_directives(data, '' if text else file)):
        return read_directives(data, file, folder, resolver, options)
    return parse_scene(read_yaml(text_of(data, file), file, MOST_ITEMS), folder, resolver)


def load_scene(
    path_or_text: PathLike,
    scene_graph: SceneGraph,
    format: str = '',
    srdf: PathLike = '',
    package_roots: Roots = (),
) -> LoadedScene:
    """Register all contents of a scene file, and return the ids by name.

    Arguments and errors are those of ``read_scene`` and ``register``; after an error the scene
    graph is unchanged. Each warning of the file is also issued as a UserWarning.
    """
    description = read_scene(path_or_text, format, srdf, package_roots)
    loaded = register(scene_graph, description)
    sensors = sensors_left_out(description.obstacle_sources)
    gates = gates_left_out(description.gates)
    for warning in filter(None, (*loaded.warnings, sensors, gates)):
        warnings.warn(warning, stacklevel=2)
    return loaded


def save_scene(
    scene_graph: SceneGraph,
    X_PFs: Mapping[FrameId, RigidTransform] | None = None,
    robots: Iterable[RobotDescription] = (),
    cameras: Iterable[tuple[FrameId, CameraDescription]] = (),
) -> str:
    """Return the YAML text of a scene, from which ``load_scene`` makes the same scene.

    The text preserves names and order of sources, frames and geometries, poses, shapes, roles,
    properties, and persistent filters, but no transient declarations. ``X_PFs``, ``robots`` and
    ``cameras`` add what a scene graph does not hold: poses of frames, and the robots and cameras
    of ``LoadedScene``. Meshes are saved by path.

    Raises SceneFileError for contents that the format cannot express.
    """
    return to_yaml(describe(scene_graph, X_PFs, robots, cameras=cameras))


def _urdf_scene(
    data: bytes,
    file: str,
    folder: Path,
    path: Path | None,
    srdf: PathLike,
    resolver: ResourceResolver,
    options: RobotOptions,
) -> SceneDescription:
    robot = robot_name(data, file)
    name = options.source or robot
    parts = read_urdf(data, file, name, folder, resolver, options)
    filters, warnings = parts.filters, parts.warnings
    srdf_path, groups, virtual = None, dict[str, tuple[str, ...]](), dict[str, str]()
    if srdf:
        srdf_file = TEXT
        if _as_text(srdf):
            srdf_data, _ = _content(srdf)
        else:
            srdf_path = Path(srdf).absolute()
            srdf_data, srdf_file = read_robot_file(Path(srdf), resolver.is_free)
        semantics = read_srdf(srdf_data, srdf_file, name, robot, parts.link_names, options)
        filters, warnings = filters + semantics.filters, warnings + semantics.warnings
        groups = link_groups(srdf_data, srdf_file, parts.tree)
        virtual = virtual_joints(srdf_data, srdf_file, parts.link_names)
    described = RobotDescription(
        name,
        urdf=path,
        X_WB=RigidTransform(),
        srdf=srdf_path,
        tree=parts.tree,
        frame_prefix=options.frame_prefix,
        groups=groups,
        virtual_joints=virtual,
    )
    return SceneDescription(
        file,
        sources=(name,),
        robots=(described,),
        frames=parts.frames,
        geometries=parts.geometries,
        filters=filters,
        warnings=warnings,
    )


def _models_scene(
    data: bytes,
    file: str,
    folder: Path,
    path: Path | None,
    resolver: ResourceResolver,
    options: RobotOptions,
) -> SceneDescription:
    """Return the scene of all models of a file of SDFormat or MuJoCo."""
    models: Mapping[str, RobotParts]
    welds: list[Weld] = []
    if root_tag(data) == 'mujoco':
        parts = read_mjcf(path, data, file, resolver, options)
        models = {parts.tree.name: parts}
    else:
        models, welds = read_sdf(data, file, folder, resolver, options)
    robots = [
        RobotDescription(
            name,
            urdf=path,
            X_WB=RigidTransform(),
            tree=parts.tree,
            frame_prefix=options.frame_prefix,
            model=name if len(models) > 1 else '',
        )
        for name, parts in models.items()
    ]
    pairs = zip(robots, models.values(), strict=True)
    return welded_scene(file, pairs, welds, {}, [], options)


def _as_text(path_or_text: PathLike) -> str:
    """Return the text if the argument is one, '' if it is a path."""
    if not isinstance(path_or_text, str):
        return ''
    is_text = '\n' in path_or_text or path_or_text.lstrip('\ufeff \t').startswith(('{', '<'))
    return path_or_text if is_text else ''


def _content(path_or_text: PathLike) -> tuple[bytes, Path]:
    """Return content and folder of a file or a text."""
    if text := _as_text(path_or_text):
        return text.encode(errors='surrogatepass'), Path.cwd()
    path = Path(path_or_text)
    try:
        with path.open('rb') as stream:
            data = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise unreadable(str(path_or_text), error) from error
    if len(data) > MAX_BYTES:
        raise SceneFileError(f'more than {MAX_BYTES} bytes', str(path_or_text))
    return data, path.absolute().parent
