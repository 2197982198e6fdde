"""Values of joints in the order of Drake's position vectors."""

from collections.abc import Sequence

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.jointed_links import parts_of
from drake_geom_ros.scene_files.link_tree import LinkTree

_RPY = ('roll', 'pitch', 'yaw')


def values_of_drake(tree: LinkTree, joint: str, values: Sequence[float]) -> dict[str, float]:
    """Return values [rad] or [m] by name of a joint, from its position vector in Drake.

    A floating joint has ``qw qx qy qz x y z`` there, a ball joint roll, pitch and yaw. Raises
    ValueError or RuntimeError, which name no line, for a joint that is missing, for another number
    of values, and for a quaternion that is not unit.
    """
    matches = [each for each in tree.joints if each.name == joint]
    if not matches:
        shown = ', '.join(each.name for each in tree.joints) or 'none'
        raise ValueError(f'{tree.name!r} has no joint {joint!r}; there are {shown}')
    kind = matches[0].type
    names = [part.name for part in parts_of(matches[0]) if part.type != 'fixed' and not part.mimic]
    if kind == 'ball':
        names = [f'{joint}/{angle}' for angle in _RPY]
    count = 7 if kind == 'floating' else len(names)
    if len(values) != count:
        raise ValueError(f'{len(values)} values of the {kind} joint {joint!r}; it has {count}')
    if kind != 'floating':
        return dict(zip(names, map(float, values), strict=True))
    w, x, y, z, *position = values
    X = RigidTransform.FromArray([*position, x, y, z, w])
    rpy = X.rotation().ToRollPitchYaw().vector().tolist()
    turned = dict(zip((f'{joint}/{angle}' for angle in _RPY), rpy, strict=True))
    return dict(zip((f'{joint}/{axis}' for axis in 'xyz'), position, strict=True)) | turned
