"""Contents of a replay file: the scene, the question, the answer and the software versions."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata

from drake_geom_ros.geometry import (
    METHODS,
    GeometryId,
    QueryObject,
    SceneGraphInspector,
    SignedDistanceResults,
)
from drake_geom_ros.scene_files import describe_moment, to_yaml

_METHOD_NAMES = {number: name for name, number in METHODS.items()}
_PACKAGES = ('drake_geom_ros', 'numpy', 'numba', 'llvmlite')

Name = tuple[str, str, str]  # source, frame, geometry


@dataclass(frozen=True)
class Question:
    """The query whose answer exceeded its tolerance.

    ``hint`` is the normal of the warm start, None without one.
    """

    geometry_a: Name
    geometry_b: Name
    accuracy: str
    max_distance: float  # [m]
    hint: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Answer:
    """A signed distance with its witnesses, and the error bound that its level promises."""

    distance: float  # [m]
    nhat_BA_W: tuple[float, ...]
    p_ACa: tuple[float, ...]  # [m]
    p_BCb: tuple[float, ...]  # [m]
    error_bound: float  # [m]
    promised_error_bound: float  # [m]
    method: str
    breaks_promise: bool


@dataclass(frozen=True)
class Opinion:
    """Answer of another library to the same question, with its tolerance.

    ``distance`` None: it reports no contact. Normal and witness points are None if it has none.
    """

    library: str
    distance: float | None  # [m]
    tolerance: float  # [m]
    nhat_BA_W: tuple[float, ...] | None = None
    p_WCa: tuple[float, ...] | None = None  # [m]
    p_WCb: tuple[float, ...] | None = None  # [m]

    def differs(self, answer: Answer) -> bool:
        """Return whether an answer differs by more than its error bound plus the tolerance."""
        allowed = answer.error_bound + self.tolerance
        if self.distance is None:
            return answer.distance < -allowed
        return not abs(answer.distance - self.distance) <= allowed


@dataclass(frozen=True)
class Replay:
    """A question with the scene (YAML with all poses), the answer and the software versions.

    ``ids`` are those of the two geometries in the node's scene. ``opinion`` is another library's
    answer, if it is the reason for the replay.
    """

    scene: str
    question: Question
    ids: tuple[int, int]
    answer: Answer
    versions: Mapping[str, str]
    opinion: Opinion | None = None


def answer_of(results: SignedDistanceResults, index: int) -> Answer:
    """Return the answer for one of the results."""
    pair = results[index]
    return Answer(
        pair.distance,
        tuple(pair.nhat_BA_W.tolist()),
        tuple(pair.p_ACa.tolist()),
        tuple(pair.p_BCb.tolist()),
        pair.error_bound,
        float(results.promised_error_bound[index]),
        _METHOD_NAMES[pair.method],
        bool(results.breaks_promise()[index]),
    )


def recorded(
    query: QueryObject,
    results: SignedDistanceResults,
    index: int,
    accuracy: str,
    max_distance: float,
    hint: tuple[float, ...] | None = None,
    opinion: Opinion | None = None,
) -> Replay:
    """Return the replay of one of the ``results`` of ``query`` at its current poses.

    A ``hint`` is stored only if the answer differs without it. Raises SceneFileError for a scene
    that the format cannot express.
    """
    pair, answer = results[index], answer_of(results, index)
    inspector = query.inspector()
    names = [_name(inspector, id) for id in (pair.id_A, pair.id_B)]
    if hint is not None:
        anew = query.signed_distance_of_pair(pair.id_A, pair.id_B, accuracy=accuracy)
        hint = None if answer_of(anew, 0) == answer else hint
    return Replay(
        to_yaml(describe_moment(query)),
        Question(names[0], names[1], accuracy, max_distance, hint),
        (pair.id_A.get_value(), pair.id_B.get_value()),
        answer,
        _versions(),
        opinion,
    )


def _name(inspector: SceneGraphInspector, geometry: GeometryId) -> Name:
    return (
        inspector.GetOwningSourceName(geometry),
        inspector.GetName(inspector.GetFrameId(geometry)),
        inspector.GetName(geometry),
    )


def _versions() -> dict[str, str]:
    versions = {'python': platform.python_version(), 'machine': platform.machine()}
    for package in _PACKAGES:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = 'not installed as a package'
    return versions
