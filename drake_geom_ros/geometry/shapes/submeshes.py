"""Parts of mesh files, such as those that SDFormat names."""

from __future__ import annotations

from drake_geom_ros.geometry.meshes.source import MeshData, part_of


def submesh(filename: str, name: str, is_centred: bool = False) -> MeshData:
    """Return the part of a mesh file that has a name in it, unscaled.

    The name is that of an object or group of OBJ, or of a node of glTF or Collada. With
    ``is_centred`` the middle of the part's box along the axes is the origin. Raises MeshFileError
    for a file that cannot be read, and for a name that it does not have.
    """
    part = part_of(filename, name)
    if not is_centred:
        return part
    middle = 0.5 * (part.vertices.min(axis=0) + part.vertices.max(axis=0))
    return MeshData(part.vertices - middle, part.triangles)
