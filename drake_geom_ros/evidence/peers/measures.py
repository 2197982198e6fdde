"""The numbers of a shape, read by its accessors: what every peer's own shapes are made from."""

from __future__ import annotations

from drake_geom_ros.geometry import Convex, Mesh, Shape


class SolidMesh(Mesh):
    """A mesh that stands for the body which its surface encloses, for peers that take triangles.

    To the others it is its convex hull, as every mesh is.
    """

    __slots__ = ()


ACCESSORS = {
    'Sphere': ('radius',),
    'Box': ('width', 'depth', 'height'),
    'Capsule': ('radius', 'length'),
    'Cylinder': ('radius', 'length'),
    'Ellipsoid': ('a', 'b', 'c'),
    'HalfSpace': (),
}


def kind_of(shape: Shape) -> str:
    """Return the name of a shape's type; a Mesh is a Convex, for peers get its hull."""
    return 'Convex' if isinstance(shape, (Convex, Mesh)) else type(shape).__name__


def measures(shape: Shape) -> tuple[float, ...]:
    """Return what the shape was made from [m], in the order of its constructor."""
    return tuple(float(getattr(shape, name)()) for name in ACCESSORS[type(shape).__name__])
