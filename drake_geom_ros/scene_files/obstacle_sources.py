"""Obstacle sources of scene files: the sensors from which a node makes maps; and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.schema import check_schema, scene_schema
from drake_geom_ros.scene_files.yaml_text import Document, KeyPath, read_yaml

LASER_SCAN, POINT_CLOUD = 'laser_scan', 'point_cloud'
DEPTH_IMAGE, RANGE = 'depth_image', 'range'
OCTOMAP, OCCUPANCY_GRID = 'octomap', 'occupancy_grid'
TYPES = (LASER_SCAN, POINT_CLOUD, DEPTH_IMAGE, RANGE, OCTOMAP, OCCUPANCY_GRID)
MAPS = OCTOMAP, OCCUPANCY_GRID  # their messages are maps already
FREE, OCCUPIED = 'free', 'occupied'
RESERVED = 'file'  # the map that load_obstacles makes
# The types of sources that each key is for, of keys that are not for all.
_OF_POINTS = tuple(kind for kind in TYPES if kind not in MAPS)
_TYPES_OF_KEYS = {
    **dict.fromkeys(('resolution', 'range', 'keep', 'keep_hidden', 'rays'), _OF_POINTS),
    **dict.fromkeys(('noise', 'padding', 'least_points'), _OF_POINTS),
    'extrude': (*_OF_POINTS, OCCUPANCY_GRID),
    'may_be_empty': (POINT_CLOUD, DEPTH_IMAGE),
    'sensor': (POINT_CLOUD,),
    **dict.fromkeys(('threshold', 'unknown'), (OCCUPANCY_GRID,)),
    'static': MAPS,
}
_NO_KEYS = ('name', 'where', 'paddings')
_SECTION = 'obstacle_sources'
_DEFAULT = 'default'  # key of the padding of all bodies without one of their own


class SourceQos(NamedTuple):
    """Policies of a subscription; None: as usual for sensors."""

    reliability: str | None = None  # 'reliable' or 'best_effort'
    durability: str | None = None  # 'volatile' or 'transient_local'
    depth: int | None = None


_USUAL = SourceQos()
_LATCHED = SourceQos('reliable', 'transient_local')  # as map servers publish


@dataclass(frozen=True)
class ObstacleSource:
    """A topic of a sensor, and the map that is made of it: ``obstacles::NAME``.

    Lengths [m] and times [s]; for None the parameters ``obstacle_...`` of the node count.

    - ``type``: one of ``TYPES``.
    - ``frame``: replaces the ``frame_id`` of its messages.
    - ``sensor``: the frame of the sensor, where its clouds come in another one.
    - ``timeout``: the map is stale from this age on; None: as any pose of the node.
    - ``static``: a map that holds for good, whatever its stamp.
    - ``required``: whether a rule about the map is stale with it.
    - ``range``: points farther from the sensor are left out.
    - ``keep_hidden``: how long cells in the shadow of a body stay after they were seen last.
    - ``paddings``: those of bodies, by name or pattern; of those that fit the last one counts.
    - ``may_be_empty``: a message without points shows that nothing is there.
    - ``threshold``, ``unknown``: the least value of occupied cells of an occupancy grid, and
      whether its unknown cells count as FREE or OCCUPIED.
    - ``extrude``: heights (low, high) in the world that each seen cell stands for.
    - ``qos``: policies of its subscription.
    """

    name: str
    type: str
    topic: str
    frame: str = ''
    sensor: str = ''
    timeout: float | None = None
    static: bool = False
    required: bool = True
    resolution: float | None = None
    range: float | None = None
    box: tuple[float, ...] | None = None
    keep: float | None = None
    keep_hidden: float | None = None
    rays: bool | None = None
    noise: float | None = None
    padding: float | None = None
    paddings: tuple[tuple[str, float], ...] = ()
    least_points: int | None = None
    extrude: tuple[float, float] | None = None
    may_be_empty: bool | None = None
    threshold: int | None = None
    unknown: str | None = None
    qos: SourceQos = _USUAL
    where: Location = field(default=Location('<scene>'), compare=False)


def read_obstacle_sources(document: Document) -> tuple[ObstacleSource, ...]:
    """Return the sources of a document; raises SceneFileError for an invalid one."""
    plain: Mapping[str, Any] = document.value.get(_SECTION, {})
    return tuple(_source(document, name, each) for name, each in plain.items())


def obstacle_sources_of_text(text: str, called: str) -> tuple[ObstacleSource, ...]:
    """Return the sources of a YAML text as it stands below ``obstacle_sources`` of a scene file.

    ``called`` is the name of the text in errors. Raises SceneFileError for an invalid one.

    >>> text = '{front: {type: laser_scan, topic: /scan}}'
    >>> [source.topic for source in obstacle_sources_of_text(text, 'example')]
    ['/scan']
    """
    return _of_section(read_yaml(text, called), (_SECTION,))


def obstacle_source_of_text(name: str, settings: str, called: str) -> ObstacleSource:
    """Return a source of the YAML text of its keys, such as ``{type: octomap, topic: /map}``.

    ``called`` is the name of the text in errors. Raises SceneFileError for an invalid one.
    """
    (source,) = _of_section(read_yaml(settings, called), (_SECTION, name))
    return source


def _of_section(document: Document, path: KeyPath) -> tuple[ObstacleSource, ...]:
    """Return the sources of a document that stands at a path of a scene file."""
    lines: dict[KeyPath, int] = {path[:k]: 1 for k in range(len(path))}
    lines.update({(*path, *inner): line for inner, line in document.lines.items()})
    value = document.value
    for key in reversed(path):
        value = {key: value}
    whole = Document(document.file, value, lines)
    check_schema(whole, scene_schema())
    return read_obstacle_sources(whole)


def _source(document: Document, name: str, plain: Mapping[str, Any]) -> ObstacleSource:
    path = _SECTION, name
    where = document.at(*path)
    if name == RESERVED:
        raise where.error(
            f'{name!r} is the map that load_obstacles makes; give the source another name'
        )
    for key in plain:
        types = _TYPES_OF_KEYS.get(key, TYPES)
        if plain['type'] not in types:
            raise document.at(*path, key).error(
                f'{key} is for {", ".join(types)}, and {name} is of type {plain["type"]}; '
                'leave it out'
            )
    box, extrude = plain.get('box'), plain.get('extrude')
    if box is not None and not all(low < high for low, high in zip(box, box[3:], strict=False)):
        raise document.at(*path, 'box').error(
            f'{box} must be x, y, z of the lowest and of the highest corner [m], each of the '
            'first three less than its fellow'
        )
    if extrude is not None and not extrude[0] < extrude[1]:
        raise document.at(*path, 'extrude').error(
            f'{extrude} must be the lowest and the highest height [m], the first one less'
        )
    if plain.get('static') and 'timeout' in plain:
        raise document.at(*path, 'timeout').error(
            'a static map never grows old; leave out timeout, or static'
        )
    values = {**plain, 'where': where}
    if box is not None:
        values['box'] = tuple(map(float, box))
    if extrude is not None:
        values['extrude'] = float(extrude[0]), float(extrude[1])
    if isinstance(padding := plain.get('padding'), dict):
        values['padding'] = padding.get(_DEFAULT)
        values['paddings'] = tuple(item for item in padding.items() if item[0] != _DEFAULT)
    if 'qos' in plain:
        values['qos'] = SourceQos(**plain['qos'])
    elif plain.get('static'):
        values['qos'] = _LATCHED
    return ObstacleSource(name, **values)


def sensors_left_out(sources: Sequence[ObstacleSource]) -> str:
    """Return a warning that no map of these sources is made here; empty where there are none."""
    if not sources:
        return ''
    names = ', '.join(each.name for each in sources)
    reason = (
        f'obstacle_sources ({names}) are maps that a node makes of what sensors see: here none '
        'of that is in any answer'
    )
    return str(sources[0].where.error(reason))


def plain_obstacle_source(source: ObstacleSource) -> dict[str, Any]:
    """Return the plain form of a source, without defaults."""
    plain: dict[str, Any] = {}
    for each in fields(source):
        value = getattr(source, each.name)
        if each.name in _NO_KEYS or value == each.default:
            continue
        if isinstance(value, SourceQos):
            policies = value._asdict().items()
            plain[each.name] = {key: policy for key, policy in policies if policy is not None}
        else:
            plain[each.name] = list(value) if isinstance(value, tuple) else value
    if source.paddings:
        usual = {} if source.padding is None else {_DEFAULT: source.padding}
        plain['padding'] = {**usual, **dict(source.paddings)}
    return plain
