"""What a URDF may say: elements and attributes that are read, and those that change no answer.

Whatever else it says could mean a shape, a pose or a filter that is not understood. It is refused
where the meaning is sure to be lost (an orientation in words of its own, xacro that nobody
expanded, a known name in other letters), and otherwise named in a warning, once for each kind.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from lxml import etree

from drake_geom_ros.scene_files.urdf_proximity import KNOWN_PROPERTIES
from drake_geom_ros.scene_files.xml_tree import XACRO_FIRST, local_name, place_of

_VERSIONS = ('1', '1.0', '1.1', '1.2')
_SHOWN = 60  # characters of a value


@dataclass(frozen=True)
class _Known:
    """Of an element: its attributes, the elements in it, and what may be in it without effect.

    Of ``once`` an element has one at most.
    """

    attributes: frozenset[str] = frozenset()
    elements: frozenset[str] = frozenset()
    without_effect: frozenset[str] = frozenset()
    once: frozenset[str] = field(default=frozenset())


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# By local name. What is without effect: masses, visuals, motors, limits beyond position and speed,
# sensors, the worlds of simulators, and Drake's forces and constraints.
_KNOWN = {
    'robot': _Known(
        _words('name version'),
        _words('link joint collision_filter_group'),
        _words(
            'material transmission gazebo ros2_control sensor mujoco linear_bushing_rpy '
            'ball_constraint distance_constraint tendon_constraint frame'
        ),
    ),
    'link': _Known(
        _words('name type'),
        _words('collision'),
        _words('visual inertial contact surface sensor gazebo kinematic gravity self_filter'),
    ),
    'collision': _Known(
        _words('name'),
        _words('origin geometry proximity_properties'),
        _words('material contact_coefficients verbose surface'),
        _words('origin geometry proximity_properties'),
    ),
    'proximity_properties': _Known(
        elements=frozenset(KNOWN_PROPERTIES),
        without_effect=_words('mu_dynamic mu_static'),
        once=frozenset(KNOWN_PROPERTIES),
    ),
    **{name: _Known(_words('value')) for name in KNOWN_PROPERTIES},
    'origin': _Known(_words('xyz rpy quat_xyzw wxyz')),
    'geometry': _Known(
        _words('name'),
        _words('box sphere cylinder capsule ellipsoid mesh'),
    ),
    'box': _Known(_words('size')),
    'sphere': _Known(_words('radius')),
    'cylinder': _Known(_words('radius length')),
    'capsule': _Known(_words('radius length')),
    'ellipsoid': _Known(_words('a b c')),
    'mesh': _Known(_words('filename scale'), _words('declare_convex')),
    'declare_convex': _Known(),
    'joint': _Known(
        _words('name type dont_collapse'),
        _words('parent child origin axis limit mimic'),
        _words(
            'dynamics safety_controller calibration limits_ext rotor_inertia gear_ratio '
            'controller_gains hardwareInterface gazebo'
        ),
        _words('parent child origin axis limit mimic'),
    ),
    'parent': _Known(_words('link')),
    'child': _Known(_words('link')),
    'axis': _Known(_words('xyz')),
    'limit': _Known(_words('lower upper velocity')),
    'mimic': _Known(_words('joint multiplier offset')),
}
# Whatever else these hold changes no answer: efforts, currents, accelerations.
_MAY_HOLD_ANYTHING = _words('limit')
# The others read these.
_READ_ELSEWHERE = _words('collision_filter_group')
# As Drake writes them; what else is in a namespace is not what has the same name in none.
_OF_ANY_NAMESPACE = _words(
    'collision_filter_group joint capsule ellipsoid declare_convex proximity_properties'
).union(KNOWN_PROPERTIES)
# A word that is not known is an orientation or a length that is not read.
_REFUSED_IN = _words('origin')


def check_vocabulary(root: Any, file: str) -> tuple[str, ...]:
    """Return what a URDF says that is not understood, in words with file and line.

    Raises SceneFileError for what cannot be meant as it is read: see above.
    """
    first: dict[str, str] = {}
    count: dict[str, int] = {}
    for what, told in _unknown(root, file):
        first.setdefault(what, told)
        count[what] = count.get(what, 0) + 1
    more = {what: f' (and {n - 1} more like it)' if n > 1 else '' for what, n in count.items()}
    return tuple(f'{told}{more[what]}' for what, told in first.items())


def _unknown(element: Any, file: str) -> Iterator[tuple[str, str]]:
    """Yield the kind of each thing that is not understood, and what to say of it."""
    name = local_name(element)
    known = _KNOWN[name]
    place = place_of(element, file)
    for attribute, value in element.attrib.items():
        plain = etree.QName(attribute).localname
        is_ours = attribute == plain
        if '${' in value or '$(' in value:
            raise place.error(f'{plain} = {value[:_SHOWN]!r} is xacro: {XACRO_FIRST}')
        if is_ours and plain in known.attributes:
            continue
        _refuse_other_letters(plain, known.attributes, place)
        if name in _MAY_HOLD_ANYTHING:
            continue
        allowed = ', '.join(sorted(known.attributes)) or 'none'
        what = f'the attribute `{plain}` of <{name}> is not understood; known: {allowed}'
        if name in _REFUSED_IN:
            raise place.error(what)
        yield what, str(place.error(f'{what}. It is left out'))
    if name == 'robot' and element.get('version', '1.0').strip() not in _VERSIONS:
        what = f'version {element.get("version")[:_SHOWN]!r}; known are {", ".join(_VERSIONS)}'
        yield what, str(place.error(f'{what}. It is read as one of these'))
    seen: set[str] = set()
    for child in element:
        yield from _unknown_child(child, name, known, seen, file)


def _unknown_child(
    child: Any, parent: str, known: _Known, seen: set[str], file: str
) -> Iterator[tuple[str, str]]:
    name, place = local_name(child), place_of(child, file)
    if 'xacro' in (child.prefix or '') or 'xacro' in (etree.QName(child).namespace or ''):
        raise place.error(f'<{child.prefix}:{name}> is xacro: {XACRO_FIRST}')
    if name in known.once and name in seen:
        raise place.error(f'a second <{name}> in one <{parent}>; one is allowed')
    seen.add(name)
    is_ours = not child.prefix or name in _OF_ANY_NAMESPACE
    if is_ours and name in known.elements:
        if name not in _READ_ELSEWHERE:
            yield from _unknown(child, file)
    elif name not in known.without_effect:
        _refuse_other_letters(name, known.elements, place)
        shown = f'{child.prefix}:{name}' if child.prefix else name
        what = f'<{shown}> in <{parent}> is not understood'
        yield what, str(place.error(f'{what}. It is left out'))


def _refuse_other_letters(name: str, known: frozenset[str], place: Any) -> None:
    """Refuse a known name in other letters: all who read URDF would leave it out."""
    if name not in known and name.lower() in known:
        raise place.error(f'`{name}` must be written `{name.lower()}`')
