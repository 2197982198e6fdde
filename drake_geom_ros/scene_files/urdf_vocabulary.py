"""Vocabulary of URDF: elements and attributes that are read, and those that change no answer.

Anything else could mean a shape, a pose or a filter that is not understood. It is refused if its
meaning is certainly lost (an unknown way to write an orientation, xacro that was not expanded, a
name in the wrong case), and otherwise reported in a warning, once for each kind.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from lxml import etree

from drake_geom_ros.scene_files.urdf_proximity import KNOWN_PROPERTIES
from drake_geom_ros.scene_files.xml_tree import XACRO_FIRST, local_name, place_of

_VERSIONS = ('1', '1.0', '1.1', '1.2')
_SHOWN = 60  # characters of a value


@dataclass(frozen=True)
class _KnownElement:
    """Attributes and child elements of an element, and children without effect.

    Children in ``once`` may occur at most once.
    """

    attributes: frozenset[str] = frozenset()
    elements: frozenset[str] = frozenset()
    without_effect: frozenset[str] = frozenset()
    once: frozenset[str] = field(default=frozenset())


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# By local name. Without effect are masses, visuals, motors, limits beyond position and speed,
# sensors, worlds of simulators, and Drake's forces and constraints.
_KNOWN = {
    'robot': _KnownElement(
        _words('name version'),
        _words('link joint collision_filter_group'),
        _words(
            'material transmission gazebo ros2_control sensor mujoco linear_bushing_rpy '
            'ball_constraint distance_constraint tendon_constraint frame'
        ),
    ),
    'link': _KnownElement(
        _words('name type'),
        _words('collision'),
        _words('visual inertial contact surface sensor gazebo kinematic gravity self_filter'),
    ),
    'collision': _KnownElement(
        _words('name'),
        _words('origin geometry proximity_properties'),
        _words('material contact_coefficients verbose surface'),
        _words('origin geometry proximity_properties'),
    ),
    'proximity_properties': _KnownElement(
        elements=frozenset(KNOWN_PROPERTIES),
        once=frozenset(KNOWN_PROPERTIES),
    ),
    **{name: _KnownElement(_words('value')) for name in KNOWN_PROPERTIES},
    'origin': _KnownElement(_words('xyz rpy quat_xyzw wxyz')),
    'geometry': _KnownElement(
        _words('name'),
        _words('box sphere cylinder capsule ellipsoid mesh'),
    ),
    'box': _KnownElement(_words('size')),
    'sphere': _KnownElement(_words('radius')),
    'cylinder': _KnownElement(_words('radius length')),
    'capsule': _KnownElement(_words('radius length')),
    'ellipsoid': _KnownElement(_words('a b c')),
    'mesh': _KnownElement(_words('filename scale'), _words('declare_convex')),
    'declare_convex': _KnownElement(),
    'joint': _KnownElement(
        _words('name type dont_collapse'),
        _words('parent child origin axis limit mimic screw_thread_pitch'),
        _words(
            'dynamics safety_controller calibration limits_ext rotor_inertia gear_ratio '
            'controller_gains hardwareInterface gazebo'
        ),
        _words('parent child origin axis limit mimic'),
    ),
    'screw_thread_pitch': _KnownElement(_words('value')),
    'parent': _KnownElement(_words('link')),
    'child': _KnownElement(_words('link')),
    'axis': _KnownElement(_words('xyz')),
    'limit': _KnownElement(_words('lower upper velocity')),
    'mimic': _KnownElement(_words('joint multiplier offset')),
}
# Other attributes of these change no answer: efforts, currents, accelerations.
_MAY_HOLD_ANYTHING = _words('limit')
# Read by other modules.
_READ_ELSEWHERE = _words('collision_filter_group')
# Drake writes these with a namespace; any other element with a namespace is not the plain one.
_OF_ANY_NAMESPACE = _words(
    'collision_filter_group joint capsule ellipsoid declare_convex proximity_properties '
    'screw_thread_pitch parent child'
).union(KNOWN_PROPERTIES)
# An unknown attribute here would be an orientation or a length that is not read.
_REFUSED_IN = _words('origin')


def check_vocabulary(root: Any, file: str) -> tuple[str, ...]:
    """Return warnings, with file and line, about parts of a URDF that are not understood.

    Raises SceneFileError for parts whose meaning is certainly lost, see the module.
    """
    return once_for_each_kind(_unknown(root, file))


def once_for_each_kind(warnings: Iterable[tuple[str, str]]) -> tuple[str, ...]:
    """Return the first warning of each kind, with the number of the others."""
    first: dict[str, str] = {}
    count: dict[str, int] = {}
    for what, warning in warnings:
        first.setdefault(what, warning)
        count[what] = count.get(what, 0) + 1
    more = {what: f' (and {n - 1} more like it)' if n > 1 else '' for what, n in count.items()}
    return tuple(f'{warning}{more[what]}' for what, warning in first.items())


def _unknown(element: Any, file: str) -> Iterator[tuple[str, str]]:
    """Yield the kind of each part that is not understood, and the warning about it."""
    name = local_name(element)
    vocabulary = _KNOWN[name]
    for attribute, value in element.attrib.items():
        plain = etree.QName(attribute).localname
        has_no_namespace = attribute == plain
        if '${' in value or '$(' in value:
            raise place_of(element, file).error(
                f'{plain} = {value[:_SHOWN]!r} is xacro: {XACRO_FIRST}'
            )
        if has_no_namespace and plain in vocabulary.attributes:
            continue
        _refuse_other_case(plain, vocabulary.attributes, element, file)
        if name in _MAY_HOLD_ANYTHING:
            continue
        allowed = ', '.join(sorted(vocabulary.attributes)) or 'none'
        what = f'the attribute `{plain}` of <{name}> is not understood; known: {allowed}'
        if name in _REFUSED_IN:
            raise place_of(element, file).error(what)
        yield what, str(place_of(element, file).error(f'{what}. It is left out'))
    if name == 'robot' and element.get('version', '1.0').strip() not in _VERSIONS:
        what = f'version {element.get("version")[:_SHOWN]!r}; known are {", ".join(_VERSIONS)}'
        yield what, str(place_of(element, file).error(f'{what}. It is read as one of these'))
    seen: set[str] = set()
    for child in element:
        yield from _unknown_child(child, name, vocabulary, seen, file)


def _unknown_child(
    child: Any, parent: str, vocabulary: _KnownElement, seen: set[str], file: str
) -> Iterator[tuple[str, str]]:
    name = local_name(child)
    if 'xacro' in (child.prefix or '') or 'xacro' in (etree.QName(child).namespace or ''):
        raise place_of(child, file).error(f'<{child.prefix}:{name}> is xacro: {XACRO_FIRST}')
    if name in vocabulary.once and name in seen:
        raise place_of(child, file).error(f'a second <{name}> in one <{parent}>; one is allowed')
    seen.add(name)
    is_plain = not child.prefix or name in _OF_ANY_NAMESPACE
    if is_plain and name in vocabulary.elements:
        if name not in _READ_ELSEWHERE:
            yield from _unknown(child, file)
    elif name not in vocabulary.without_effect:
        _refuse_other_case(name, vocabulary.elements, child, file)
        shown = f'{child.prefix}:{name}' if child.prefix else name
        what = f'<{shown}> in <{parent}> is not understood'
        yield what, str(place_of(child, file).error(f'{what}. It is left out'))


def _refuse_other_case(name: str, names: frozenset[str], element: Any, file: str) -> None:
    """Refuse a name of the vocabulary in the wrong case, which every URDF reader would skip."""
    if name not in names and name.lower() in names:
        raise place_of(element, file).error(f'`{name}` must be written `{name.lower()}`')
