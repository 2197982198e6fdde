"""Models of MuJoCo: the bodies, joints and geometries of a compiled ``mujoco.MjModel``.

MuJoCo itself compiles an MJCF file, with its defaults, includes, frames, replicates and assets.
Source of the meaning: MuJoCo's documentation of computation and of ``MjModel``, and
``mj_kinematics`` as observed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Lock
from typing import Any

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    WORLD,
    FilterDescription,
    FrameDescription,
    RobotOptions,
)
from drake_geom_ros.scene_files.errors import Location, SceneFileError
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.scene_files.mujoco_filters import filters_of
from drake_geom_ros.scene_files.mujoco_joints import joint_of, pose_of
from drake_geom_ros.scene_files.mujoco_shapes import geometries_of
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.robot_parts import RobotParts, visual_only_warning
from drake_geom_ros.scene_files.urdf_filters import moved_links, self_cliques, welded_links

_MISSING = (
    'this is MJCF, which MuJoCo reads, and that is not installed: '
    "pip install 'drake_geom_ros[mujoco]'"
)

_ONE_AT_A_TIME = Lock()  # MuJoCo keeps its handler of warnings in a global


def read_mjcf(
    path: Path | None,
    data: bytes,
    file: str,
    resolver: ResourceResolver,
    options: RobotOptions,
    source: str = '',
) -> RobotParts:
    """Return the parts of a model of MuJoCo from a file, or from its text if there is no path.

    Raises SceneFileError if MuJoCo is not installed or refuses the model, for a resolver with
    allowed folders, since MuJoCo opens any file that the model names, and as ``parts_of_model``.
    """
    if not resolver.is_free:
        reason = 'this is MJCF, which may open any file; it is read from files of your own only'
        raise SceneFileError(reason, file)
    try:
        import mujoco
    except ImportError:
        raise SceneFileError(_MISSING, file) from None
    said: list[str] = []
    with _ONE_AT_A_TIME:
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(said.append)  # instead of a log in the working folder
        try:
            if path is not None:
                model = mujoco.MjModel.from_xml_path(str(path))
            else:
                model = mujoco.MjModel.from_xml_string(data.decode())
        except ValueError as error:
            reason = ' '.join(str(error).split())
            raise SceneFileError(f'MuJoCo refuses it: {reason}', file) from None
        finally:
            mujoco.set_mju_user_warning(before)
    parts = parts_of_model(model, source or model_name(model), options, file)
    where = Location(file)
    warnings = tuple(str(where.error(f'MuJoCo warns: {text.strip()}')) for text in said)
    return replace(parts, warnings=(*warnings, *parts.warnings))


def model_name(model: Any) -> str:
    """Return the name of a compiled model."""
    return bytes(model.names).split(b'\0', 1)[0].decode(errors='replace') or 'mujoco'


@dataclass(frozen=True)
class _Bodies:
    """Names of bodies by id; the first is the world."""

    names: tuple[str, ...]
    X_PBs: tuple[RigidTransform, ...]


def parts_of_model(model: Any, source: str, options: RobotOptions, file: str) -> RobotParts:
    """Return the parts of a compiled model, owned by ``source``.

    Bodies become links of one tree whose root is the world; their names are those of the model,
    or ``body_ID``. Geometries that collide with nothing are left out. Raises SceneFileError for
    shapes that are not read: height fields, signed distance fields and flexible bodies.
    """
    where = Location(file)
    bodies = _bodies_of(model)
    joints = tuple(_joints(model, bodies, where))
    tree = LinkTree(model_name(model), bodies.names, joints)
    geometries, ids = geometries_of(model, source, bodies.names, options, where)
    moved, welded = moved_links(joints), welded_links(joints, options)
    frames = tuple(
        FrameDescription(
            source,
            name,
            static=False if name in moved else None,
            where=where,
            welded=name in welded,
        )
        for name in bodies.names[1:]
    )
    shaped = {geometry.frame for geometry in geometries}
    members = dict(zip(ids, geometries, strict=True))
    filters: tuple[FilterDescription, ...] = (
        *filters_of(model, members, options, where),
        *self_cliques(shaped - {WORLD}, source, options),
    )
    X_PBs = dict(zip(bodies.names, bodies.X_PBs, strict=True))
    free = {joint.child: X_PBs[joint.child] for joint in joints if joint.type == 'floating'}
    offsets = dict(_sites(model, bodies))
    return RobotParts(
        frames,
        geometries,
        filters,
        tree,
        (
            *(str(where.error(text)) for text in _warnings(model, shaped)),
            *visual_only_warning(_visual_only(model, bodies, shaped), model.nbody - 1, where),
        ),
        offsets,
        RigidTransform(),
        free,
    )


def _bodies_of(model: Any) -> _Bodies:
    names: list[str] = [WORLD]
    for id in range(1, model.nbody):
        name = model.body(id).name or f'body_{id}'
        while name in names:
            name += '_'
        names.append(name)
    X_PBs = [pose_of(p, q) for p, q in zip(model.body_pos, model.body_quat, strict=True)]
    return _Bodies(tuple(names), tuple(X_PBs))


def _joints(model: Any, bodies: _Bodies, where: Location) -> Iterator[UrdfJoint]:
    """Yield the joint of each body with its parent."""
    for id in range(1, model.nbody):
        ends = bodies.names[model.body_parentid[id]], bodies.names[id]
        yield joint_of(model, id, ends, bodies.X_PBs[id], where)


def _sites(model: Any, bodies: _Bodies) -> Iterator[tuple[str, tuple[str, RigidTransform]]]:
    """Yield the named sites, each with its body and its pose on it."""
    for id in range(model.nsite):
        if name := model.site(id).name:
            X_BS = pose_of(model.site_pos[id], model.site_quat[id])
            yield name, (bodies.names[model.site_bodyid[id]], X_BS)


def _visual_only(model: Any, bodies: _Bodies, shaped: Collection[str]) -> list[str]:
    """Return the bodies with geometries none of which collides with anything."""
    if not shaped:
        return []
    with_geometries = dict.fromkeys(bodies.names[id] for id in model.geom_bodyid.tolist())
    return [name for name in with_geometries if name != WORLD and name not in shaped]


def _warnings(model: Any, shaped: Collection[str]) -> Iterator[str]:
    """Yield what the model has that changes contacts in MuJoCo, and no distance here."""
    import mujoco

    if not shaped:
        yield 'no geometry of the model collides with anything: no query sees anything of it'
    margins = int((model.geom_margin != 0.0).sum())
    if margins:
        yield (
            f'{margins} geometries have a margin, within which MuJoCo makes contacts; distances '
            'here are those of the shapes themselves'
        )
    off = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    if model.opt.disableflags & off:
        yield 'contacts are disabled by a flag in MuJoCo; here they are not'
    if model.nkey:
        yield f'{model.nkey} keyframes are not read: joints have no first values'
