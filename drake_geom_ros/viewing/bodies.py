"""Bodies of a scene for people: shape, size, roles and properties, and the distance of two."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drake_geom_ros.geometry import (
    Convex,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    GeometryInstance,
    GeometryProperties,
    Mesh,
    ProximityProperties,
    QueryObject,
    Role,
    RoleError,
    SceneGraph,
    Shape,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.yaml_values import ROLE_NAMES, plain_shape
from drake_geom_ros.viewing.shown_pairs import ReportedPairs

_MOST_LETTERS = 120  # of the text of a property
_PADDING = ('proximity', 'padding')


@dataclass(frozen=True, eq=False)
class ShownBody:
    """A geometry as it is registered; ``name`` is ``source::frame/geometry``."""

    value: int
    name: str
    source: str
    frame: str
    shape: Shape
    roles: Mapping[Role, GeometryProperties] = field(default_factory=dict)

    @property
    def padding(self) -> float:
        """The margin [m] by which queries enlarge the body on all sides."""
        properties = self.roles.get(Role.kProximity)
        return 0.0 if properties is None else properties.GetPropertyOrDefault(*_PADDING, 0.0)

    def rows(self) -> list[tuple[str, str]]:
        """Return labels and texts: shape, sizes, frame, roles with their properties, margin."""
        kind, sizes = size_in_words(self.shape)
        rows = [('shape', kind), *sizes, ('source', self.source), ('frame', self.frame)]
        for role, properties in sorted(self.roles.items(), key=lambda item: int(item[0])):
            texts = properties_in_words(properties)
            rows.append((f'role {ROLE_NAMES[role]}', '; '.join(texts) or 'no properties'))
        rows.append(('margin', f'{1e3 * self.padding:g} mm'))
        return rows


def size_in_words(shape: Shape) -> tuple[str, list[tuple[str, str]]]:
    """Return the kind of a shape, and labels and texts of its sizes."""
    if isinstance(shape, Convex | Mesh):
        vertices, triangles = shape.hull_surface()
        size = np.ptp(vertices, axis=0)
        kind = 'convex' if isinstance(shape, Convex) else 'mesh'
        rows = [('size', _lengths(size.tolist())), ('hull', f'{len(triangles)} triangles')]
        if shape.mesh_data() is None:
            rows.append(('file', shape.filename()))
        return kind, rows
    try:
        plain = plain_shape(shape)
    except TypeError:
        return type(shape).__name__, []
    kind = plain.pop('type').replace('_', ' ')
    return kind, [
        (label.replace('_', ' '), _lengths(value if isinstance(value, list) else [value]))
        for label, value in plain.items()
        if _is_short(value)
    ]


def properties_in_words(properties: GeometryProperties) -> list[str]:
    """Return a text ``group/name = value`` for each property."""
    texts = []
    for group in sorted(properties.GetGroupNames()):
        values = properties.GetPropertiesInGroup(group)
        for name in sorted(values):
            text = f'{group}/{name} = {values[name].get_value()}'
            texts.append(text if len(text) <= _MOST_LETTERS else f'{text[: _MOST_LETTERS - 1]}…')
    return texts


class PairDistance:
    """Signed distance of two bodies however far apart they are, also where they are filtered.

    The bodies have a scene graph of their own, so that no filter and no limit of the scene counts.
    """

    def __init__(self, a: ShownBody, b: ShownBody) -> None:
        """Compile nothing yet; raises GeometryError for a body without the proximity role."""
        self._bodies = sorted((a, b), key=lambda body: body.value)
        graph = SceneGraph()
        source = graph.RegisterSource('pair')
        self._frames = []
        for number, body in enumerate(self._bodies):
            properties = body.roles.get(Role.kProximity)
            if properties is None:
                raise RoleError(f'{body.name} has no proximity role, so it has no distance')
            frame = graph.RegisterFrame(source, GeometryFrame(f'body {number}'))
            instance = GeometryInstance(RigidTransform(), body.shape, 'geometry')
            instance.set_proximity_properties(ProximityProperties(properties))
            graph.RegisterGeometry(source, frame, instance)
            self._frames.append(frame)
        self._context = graph.CreateDefaultContext()
        self._query = QueryObject(self._context)

    def between(self, X_WGs: Mapping[int, RigidTransform], accuracy: str) -> ReportedPairs:
        """Return the pair at poses by id value; raises GeometryError if it has no distance."""
        poses = {
            frame: X_WGs[body.value]
            for frame, body in zip(self._frames, self._bodies, strict=True)
        }
        self._context.UpdateFramePoses(FramePoseVector(poses))
        results = self._query.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        if not len(results):
            raise GeometryError(
                f'{self._bodies[0].name} and {self._bodies[1].name} have no distance'
            )
        pairs = ReportedPairs.of(results)
        ids: Any = [[body.value for body in self._bodies]]
        return ReportedPairs(
            np.array(ids, dtype=np.int64),
            pairs.distance,
            pairs.error_bound,
            pairs.p_WCas,
            pairs.p_WCbs,
            pairs.nhat_BA_Ws,
        )


def _is_short(value: Any) -> bool:
    values = value if isinstance(value, list) else [value]
    return len(values) <= 3 and all(isinstance(each, float | int) for each in values)


def _lengths(values: list[float]) -> str:
    return ' x '.join(f'{1e3 * value:g}' for value in values) + ' mm'
