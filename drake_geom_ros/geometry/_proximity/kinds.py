"""Kinds of shapes and methods of answers, numbered as in messages, packed arrays and kernels."""

from enum import IntEnum


class ShapeKind(IntEnum):
    """Kind of a shape. It orders a pair: A has the lower number."""

    SPHERE = 1
    BOX = 2
    CAPSULE = 3
    CYLINDER = 4
    ELLIPSOID = 5
    HALF_SPACE = 6
    CONVEX = 7
    SOLID = 8  # a mesh as the body within its surface; in messages any mesh has this number
    TRIANGLE = 9  # a leaf of a solid's tree: in kernels only
    OCCUPIED_CELLS = 10  # cubes of one size along the axes
    POINT_CLOUD = 11  # balls of one size


class Method(IntEnum):
    """Method that answered a pair."""

    CLOSED_FORM = 1
    ITERATIVE = 2
    MESH = 3
    BOUND_ONLY = 4
    OPEN = 5  # overlap of a solid or a map: a separating translation, maybe not the shortest

    @property
    def words(self) -> str:
        """The method in words for readers."""
        return self.name.lower().replace('_', ' ')


# The same as plain integers, for compiled code: for Numba a member of an IntEnum has a type of its
# own, and a function that is handed one, and a number elsewhere, is compiled twice.
(
    SPHERE,
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    CONVEX,
    SOLID,
    TRIANGLE,
    OCCUPIED_CELLS,
    POINT_CLOUD,
) = (kind.value for kind in ShapeKind)
CLOSED_FORM, ITERATIVE, MESH, BOUND_ONLY, OPEN = (method.value for method in Method)

# Where the parameters of a shape stand (see ``kernels``): of a sphere, capsule or cylinder, and of
# a hull or solid. Those of a box and an ellipsoid are a vector.
SHAPE_RADIUS, HALF_LENGTH = 0, 1
VERTEX_COUNT = 0
