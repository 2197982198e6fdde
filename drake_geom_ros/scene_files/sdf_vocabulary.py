"""Elements of SDFormat that are read, and those that change no pair and no distance.

Others could mean a shape, a pose or a filter that is not understood: they are reported in
warnings, once for each kind.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from drake_geom_ros.scene_files.sdf_models import Scope
from drake_geom_ros.scene_files.urdf_proximity import KNOWN_PROPERTIES
from drake_geom_ros.scene_files.urdf_vocabulary import once_for_each_kind
from drake_geom_ros.scene_files.xml_tree import local_name


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# By element: the children that are read, and those without effect here, such as masses, visuals,
# sensors, plugins, and what simulators do with contacts and light.
_KNOWN = {
    'sdf': _words('model world light actor'),
    'world': _words(
        'model include frame joint gravity magnetic_field atmosphere physics scene light wind '
        'plugin audio gui state spherical_coordinates population road actor'
    ),
    'model': _words(
        'link joint frame model include pose static self_collide collision_filter_group '
        'allow_auto_disable enable_wind plugin gripper sensor linear_bushing_rpy ball_constraint '
        'distance_constraint weld_constraint tendon_constraint'
    ),
    'link': _words(
        'collision pose visual inertial gravity kinematic enable_wind self_collide sensor '
        'projector audio_sink audio_source battery light particle_emitter velocity_decay '
        'must_be_base_link surface_velocity_axis plugin'
    ),
    'collision': _words(
        'geometry pose surface proximity_properties laser_retro max_contacts density '
        'auto_inertia_params material'
    ),
    'joint': _words(
        'parent child pose axis axis2 screw_thread_pitch thread_pitch mimic physics sensor '
        'gearbox_ratio gearbox_reference_body rotor_inertia gear_ratio controller_gains damping'
    ),
    'axis': _words('xyz limit mimic dynamics use_parent_model_frame initial_position'),
    'proximity_properties': frozenset(KNOWN_PROPERTIES),
}
_INSIDE = {
    'sdf': ('world',),
    'world': (),
    'model': ('link', 'joint'),
    'link': ('collision',),
    'collision': ('proximity_properties',),
    'joint': ('axis', 'axis2'),
}
# Elements whose effect on a distance is certainly lost.
_TOLD = {
    'actor': 'an actor moves by itself; no query sees it',
    'population': 'copies of models are not made',
    'road': 'a road has no shape here',
    'state': 'the poses of a state are not read; models stand where their own elements put them',
    'deformable_properties': 'a deformable body counts as the rigid shape that it has at rest',
}


def warnings_about(scopes: Iterable[tuple[Scope, Any]]) -> tuple[str, ...]:
    """Return warnings, with file and line, about elements that are not understood."""
    return once_for_each_kind(
        pair for scope, element in scopes for pair in _unknown(element, scope)
    )


def _unknown(element: Any, scope: Scope) -> Iterator[tuple[str, str]]:
    """Yield the kind of each child that is not understood, and the warning about it."""
    name = local_name(element)
    understood = _KNOWN['axis' if name == 'axis2' else name]
    inside: Sequence[str] = _INSIDE.get(name, ())
    for child in element:
        kind = local_name(child)
        place = scope.file.at(child)
        if kind in _TOLD:
            yield kind, str(place.error(f'<{kind}>: {_TOLD[kind]}'))
        elif kind not in understood:
            what = f'<{kind}> in <{name}> is not understood'
            yield what, str(place.error(f'{what}. It is left out'))
        elif kind in inside:
            yield from _unknown(child, scope)
