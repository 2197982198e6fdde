"""Configuration of a robot in a scene file: joint values, listed or by name of an SRDF state."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.jointed_links import SEVERAL, JointedLinks
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.scene_files.xml_tree import attribute, numbers, place_of, read_robot_xml

Values = Mapping[str, float]
At = Callable[..., Location]  # returns the place of a key below `configuration`
_SHOWN = 12  # names in a message
_QUATERNION = 7  # numbers of a floating joint in an SRDF: x y z, qx qy qz qw


class _Value(NamedTuple):
    """A value [rad] or [m] of a joint, and its place in a file."""

    joint: str
    value: float
    where: Location


def configuration_of(
    plain: str | Sequence[str] | Values,
    tree: LinkTree,
    srdf: tuple[bytes, str] | None,
    at: At,
    *,
    within_limits: bool,
) -> dict[str, float]:
    """Return the values by joint of the key ``configuration`` of a scene file.

    ``srdf`` are the content and the name of the robot's SRDF. Raises SceneFileError for a joint
    without a value of its own, a value beyond its limits, a state that the SRDF does not have,
    and two states that contradict each other.
    """
    try:
        links = JointedLinks(tree)
    except ValueError as error:
        raise at().error(str(error)) from None
    if isinstance(plain, Mapping):
        values = [_Value(name, float(value), at(name)) for name, value in plain.items()]
    else:
        names = [plain] if isinstance(plain, str) else plain
        values = list(_named(names, tree, links, srdf, at))
    limits = dict(zip(links.joint_names, zip(links.lower, links.upper, strict=True), strict=True))
    configuration: dict[str, float] = {}
    for joint, value, where in values:
        if joint not in limits:
            raise where.error(_no_joint(joint, tree, links))
        low, high = limits[joint]
        if within_limits and not low <= value <= high:
            raise where.error(f'{joint} = {value:g} must lie in [{low:g}, {high:g}]')
        if (first := configuration.setdefault(joint, value)) != value:
            raise where.error(
                f'{joint} has the value {first:g} in one of the states, and {value:g} here'
            )
    return configuration


def held_joints_of(
    plain: Values,
    tree: LinkTree,
    srdf: tuple[bytes, str] | None,
    configuration: Values,
    at: At,
    *,
    within_limits: bool,
) -> dict[str, float]:
    """Return the values of joints that stay: of the key ``held_joints``, and passive ones.

    Passive joints of the ``srdf``, if there is one, stay where the configuration puts them, else
    at rest. Raises SceneFileError as ``configuration_of`` does, and for another value in the
    configuration.
    """
    held: dict[str, float] = {}
    if plain:
        held = configuration_of(plain, tree, None, at, within_limits=within_limits)
    for joint, value in held.items():
        if (first := configuration.get(joint, value)) != value:
            raise at(joint).error(
                f'{joint} is held at {value:g}, and has the value {first:g} in the configuration'
            )
    if srdf is not None and (passive := _passive_joints(*srdf)):
        links = JointedLinks(tree)
        rest = dict(zip(links.joint_names, links.at_rest(configuration).tolist(), strict=True))
        held = {**{joint: rest[joint] for joint in passive if joint in rest}, **held}
    return held


def _passive_joints(data: bytes, file: str) -> list[str]:
    """Return the joints that an SRDF calls passive."""
    elements = read_robot_xml(data, file).findall('passive_joint')
    return [attribute(element, 'name', file) for element in elements]


def _no_joint(name: str, tree: LinkTree, links: JointedLinks) -> str:
    """Return the error text for a name that is no joint with a value of its own."""
    mimic = next((j.mimic for j in tree.joints if j.name == name and j.mimic), None)
    why = f' (it follows {mimic.joint!r})' if mimic else nearest(name, links.joint_names)
    return (
        f'no joint {name!r} of {tree.name!r} has a value of its own{why}; there are '
        f'{_some(links.joint_names)}'
    )


def _named(
    names: Sequence[str],
    tree: LinkTree,
    links: JointedLinks,
    srdf: tuple[bytes, str] | None,
    at: At,
) -> Iterator[_Value]:
    """Yield the values of the named states, each in all groups that have it.

    Fixed, mimicking and virtual joints are skipped, since they have no value of their own.
    """
    if srdf is None:
        raise at().error(
            f'{names[0]!r} is the name of a group_state, and the robot has no key `srdf`; list '
            'values by joint, as {joint: 0.5}'
        )
    data, file = srdf
    root = read_robot_xml(data, file)
    states = root.findall('group_state')
    state_names = list(dict.fromkeys(attribute(state, 'name', file) for state in states))
    fixed = {joint.name for joint in tree.joints} | {
        attribute(joint, 'name', file) for joint in root.findall('virtual_joint')
    }
    for index, name in enumerate(names):
        if name not in state_names:
            raise at(*([index] if len(names) > 1 else [])).error(
                f'the SRDF has no group_state {name!r}{nearest(name, state_names)}; it has '
                f'{_some(state_names)}'
            )
        for state in states:
            if state.get('name') == name:
                for element in state.findall('joint'):
                    yield from _of_state(element, tree, links, fixed, file)


def _of_state(
    element: Any, tree: LinkTree, links: JointedLinks, fixed: set[str], file: str
) -> Iterator[_Value]:
    """Yield the values of one joint of a state; raises SceneFileError for an unknown joint."""
    name, where = attribute(element, 'name', file), place_of(element, file)
    kind = next((joint.type for joint in tree.joints if joint.name == name), '')
    if kind not in SEVERAL and name not in links.joint_names:
        if name not in fixed:
            raise where.error(_no_joint(name, tree, links))
        return
    try:
        values = _of_joint(element, name, kind)
    except (ValueError, RuntimeError) as error:
        raise where.error(str(error)) from None
    for part, value in values.items():
        yield _Value(part, value, where)


def _of_joint(element: Any, name: str, kind: str) -> dict[str, float]:
    """Return the values of a joint in a state; planar and floating joints have several.

    Raises ValueError or RuntimeError for invalid numbers and for a quaternion that is not unit.
    """
    if kind not in SEVERAL:
        return {name: numbers(element, 'value', 1)[0]}
    parts = [f'{name}/{part}' for part in SEVERAL[kind]]
    if kind != 'floating':
        return dict(zip(parts, numbers(element, 'value', len(parts)), strict=True))
    X = RigidTransform.FromArray(numbers(element, 'value', _QUATERNION))
    turn = X.rotation().ToRollPitchYaw().vector()[::-1]
    return dict(zip(parts, [*X.translation().tolist(), *turn.tolist()], strict=True))


def _some(names: Sequence[str]) -> str:
    more = f' and {len(names) - _SHOWN} more' if len(names) > _SHOWN else ''
    return f'{", ".join(names[:_SHOWN]) or "none"}{more}'
