"""Names that Drake gives to collision elements of a URDF without a name, beside ours.

Drake calls the first unnamed box of a link ``Box``, the next ones ``Box_1`` and ``Box_2``. Here
they are ``collision_n``, and the name of Drake is a proximity property, by which look-ups find the
geometry too. A geometry's own name counts before the Drake name of another one.
"""

from collections.abc import Sequence

from drake_geom_ros.geometry import GeometryProperties

_GROUP, _NAME = 'drake', 'name'


def drake_names(names: Sequence[str], kinds: Sequence[str]) -> list[str]:
    """Return the names that Drake gives the collision elements of a link.

    ``names`` are those in the file, empty where there is none, and ``kinds`` the names of the
    shapes' classes. A name that is taken is followed by the first free of ``_1``, ``_2``, ...

    >>> drake_names(['', '', 'Box_1', ''], ['Box', 'Sphere', 'Box', 'Box'])
    ['Box', 'Sphere', 'Box_1', 'Box_2']
    """
    taken: dict[str, None] = {}
    for name, kind in zip(names, kinds, strict=True):
        base = unique = name or kind
        number = 0
        while unique in taken:
            number += 1
            unique = f'{base}_{number}'
        taken[unique] = None
    return list(taken)


def set_drake_name(properties: GeometryProperties, name: str) -> None:
    """Add the name that Drake gives a geometry to its properties."""
    properties.AddProperty(_GROUP, _NAME, name)


def drake_name(properties: GeometryProperties | None) -> str:
    """Return the name that Drake gives a geometry of these properties; empty if there is none."""
    if properties is None:
        return ''
    name = properties.GetPropertyOrDefault(_GROUP, _NAME, '')
    return name if isinstance(name, str) else ''


def is_drake_name(group: str, name: str) -> bool:
    """Return whether a property holds the name that Drake gives a geometry."""
    return (group, name) == (_GROUP, _NAME)
