"""Questions to a second opinion and its verdicts, as data without the judging code."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import (
    GeometryId,
    Mesh,
    OccupiedCells,
    PointCloud,
    QueryObject,
    SceneGraphInspector,
    Shape,
    SignedDistanceResults,
)
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.replay import Opinion

Pose = tuple[Floats, Floats]  # R_WG (3, 3), p_WG (3,) [m]

AGREED = 'agreed'
DISAGREED = 'disagreed'  # nothing proves the other library wrong
REFUTED = 'refuted'  # planes or points that need no solver prove the other library wrong
SILENT = 'silent'  # the other library has no comparable answer
LOST = 'lost'  # the question crashed or hung its process
VERDICTS = (AGREED, DISAGREED, REFUTED, SILENT, LOST)


class QuestionedShape(NamedTuple):
    """A shape of the scene, with the flag of a solid mesh.

    ``is_grown``: a sensed map with a margin, which the other library does not support.
    """

    shape: Shape
    is_solid: bool
    is_grown: bool = False


@dataclass(frozen=True)
class PairQuestion:
    """Two geometries by id values, with their poses and this package's answer."""

    ids: tuple[int, int]
    X_WA: Pose
    X_WB: Pose
    distance: float  # [m]
    error_bound: float  # [m]
    nhat_BA_W: Floats
    p_WCa: Floats  # [m]
    p_WCb: Floats  # [m]


@dataclass(frozen=True)
class QuestionBatch:
    """Questions about one version of a scene, with the shapes that were not sent yet."""

    version: int
    questions: list[PairQuestion]
    shapes: dict[int, QuestionedShape] = field(default_factory=dict)


class Verdict(NamedTuple):
    """Verdict on a question, one of VERDICTS; ``opinion`` is None without an answer."""

    verdict: str
    opinion: Opinion | None = None
    text: str = ''


def questions_of(
    query: QueryObject, results: SignedDistanceResults, indices: Sequence[int]
) -> list[PairQuestion]:
    """Return the questions about some of the ``results`` of ``query`` at its current poses."""
    chosen = np.asarray(indices, dtype=np.int64)
    results = results.without_padding()  # which the other library does not support
    ids_A, ids_B = results.id_A[chosen], results.id_B[chosen]
    columns = (
        zip(ids_A.tolist(), ids_B.tolist(), strict=True),
        zip(*query.X_WGs(ids_A), strict=True),
        zip(*query.X_WGs(ids_B), strict=True),
        results.distance[chosen].tolist(),
        results.error_bound[chosen].tolist(),
        results.nhat_BA_W[chosen],
        results.p_WCa[chosen],
        results.p_WCb[chosen],
    )
    return [PairQuestion(*row) for row in zip(*columns, strict=True)]


def shapes_of(query: QueryObject, ids: Iterable[int]) -> dict[int, QuestionedShape]:
    """Return the shapes of geometries by the values of their ids."""
    inspector = query.inspector()
    return {value: _shape(inspector, GeometryId(value)) for value in ids}


def _shape(inspector: SceneGraphInspector, id: GeometryId) -> QuestionedShape:
    shape, properties = inspector.GetShape(id), inspector.GetProximityProperties(id)
    if properties is not None and isinstance(shape, (OccupiedCells, PointCloud)):
        margin = properties.GetPropertyOrDefault('map', 'margin', 0.0)
        return QuestionedShape(shape, False, is_grown=margin > 0.0)
    if properties is None or not isinstance(shape, Mesh):
        return QuestionedShape(shape, False)
    return QuestionedShape(shape, bool(properties.GetPropertyOrDefault('mesh', 'solid', False)))


def counted(verdicts: Iterable[Verdict]) -> Counter[str]:
    """Return the number of verdicts of each kind."""
    return Counter(each.verdict for each in verdicts)
