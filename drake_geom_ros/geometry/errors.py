"""The errors that the scene model raises.

::

    RuntimeError                 what pydrake raises
        GeometryError            any error of this package: catch this one
            ArgumentError        a value that is not allowed (also a ValueError)
            ArgumentTypeError    a value of the wrong kind (also a TypeError)
            UnknownIdError       an id that the scene does not hold
            OwnershipError       something of another source
            DuplicateError       a name or an id that is taken
            RoleError            a role that exists already, or does not exist
            PoseError            frame poses that were refused as a whole
            FilterError          a collision filter declaration that was refused
            MeshFileError        a file that holds no usable mesh

A refused call changes nothing.
"""


class GeometryError(RuntimeError):
    """Base of the errors that ``drake_geom_ros.geometry`` raises."""


class ArgumentError(GeometryError, ValueError):
    """An argument whose value is not allowed."""


class ArgumentTypeError(GeometryError, TypeError):
    """An argument of the wrong kind."""


class UnknownIdError(GeometryError):
    """An id that the scene does not hold."""


class OwnershipError(GeometryError):
    """A frame or a geometry of another source."""


class DuplicateError(GeometryError):
    """A name or an id that is taken."""


class RoleError(GeometryError):
    """A role that the geometry already has, or does not have."""


class PoseError(GeometryError):
    """Frame poses that were refused as a whole."""


class FilterError(GeometryError):
    """A collision filter declaration that was refused."""


class MeshFileError(GeometryError):
    """A file that holds no usable mesh."""
