"""Flat meshes of robots: given a thickness or left out, as the key ``flat_meshes`` says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import Convex, Mesh
from drake_geom_ros.geometry.shapes.thickening import thickened
from drake_geom_ros.scene_files.description import LEAVE_OUT, GeometryDescription, RobotOptions
from drake_geom_ros.scene_files.errors import Location

_MOST_NAMED = 40  # geometries in a warning


def with_flat_meshes(
    geometries: Sequence[GeometryDescription], options: RobotOptions, where: Location
) -> tuple[tuple[GeometryDescription, ...], tuple[str, ...]]:
    """Return the geometries of a robot with its flat meshes changed, and a warning about them.

    Without the option ``flat_meshes`` nothing changes, and registration refuses such a mesh.
    """
    if not options.flat_meshes:
        return tuple(geometries), ()
    leaves_out = options.flat_meshes == LEAVE_OUT
    changed: list[GeometryDescription] = []
    names = []
    for geometry in geometries:
        shape = None
        if isinstance(geometry.shape, Convex | Mesh):
            try:
                shape = thickened(
                    geometry.shape, 1.0 if leaves_out else float(options.flat_meshes)
                )
            except RuntimeError as error:
                raise geometry.where.error(str(error)) from error
        if shape is None:
            changed.append(geometry)
            continue
        names.append(f'{geometry.frame}/{geometry.name}')
        if not leaves_out:
            changed.append(replace(geometry, shape=shape))
    if not names:
        return tuple(changed), ()
    shown = ', '.join(names[:_MOST_NAMED]) + ', ...' * (len(names) > _MOST_NAMED)
    fate = (
        'left out, so no query sees them'
        if leaves_out
        else f'{options.flat_meshes:g} m thick, and counted as their hulls'
    )
    warning = where.error(f'{counted(len(names), "flat mesh")}, {fate}: {shown}')
    return tuple(changed), (str(warning),)
