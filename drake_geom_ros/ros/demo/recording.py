"""Results that the demo's client keeps: short series for a person, not a bag."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.client.scene_table import SceneTable
from drake_geom_ros.common.frame_names import Frame

Floats = NDArray[np.float64]
CLOSEST_KEPT = 5
RESULTS_KEPT = 30_000  # five minutes at 100 Hz: a demo that runs forever must not grow

# of results.csv
COLUMNS = (
    'time', 'geometry_a', 'geometry_b', 'distance', 'depth', 'error_bound', 'method', 'age'
)  # fmt: skip


@dataclass(frozen=True)
class RecordedPairs:
    """The closest pairs of one result, closest first; times are stamps [s].

    Of each two things (links, objects) the closest geometries only. ``between`` [m] is the
    smallest distance between the two robots, infinite where none was reported.
    """

    time: float
    id_a: NDArray[np.int64]
    id_b: NDArray[np.int64]
    distance: Floats
    error_bound: Floats
    method: NDArray[np.uint8]
    age: float  # [s] from the stamp of the poses to the arrival of the answer
    between: float = np.inf


@dataclass(frozen=True)
class Contact:
    """The deepest penetration of one result: depth 0 and ids 0 where there is none."""

    time: float
    depth: float
    id_a: int = 0
    id_b: int = 0


@dataclass(frozen=True)
class FilterChange:
    """A change of the collision filters that the client asked for, when it was answered [s]."""

    time: float
    text: str


@dataclass(frozen=True)
class RuleEvent:
    """A proximity rule of the node was entered or left, by poses of the stamp ``time`` [s]."""

    time: float
    rule: str
    level: str  # warn, slow or stop
    entered: bool
    distance: float  # [m] of the rule's nearest pair; inf or NaN where there is none


@dataclass(frozen=True)
class Approach:
    """The closest moment of two robots: the pair, its witnesses and every frame's pose X_WF."""

    time: float
    id_a: int
    id_b: int
    distance: float
    p_WCa: Floats
    p_WCb: Floats
    nhat_BA_W: Floats
    X_WFs: Mapping[Frame, Floats]


@dataclass
class Recording:
    """Everything that the files of ``out/demo`` are written from."""

    scene: SceneTable
    robots: tuple[str, ...] = ()  # their sources; the closest moment of the first two is pictured
    max_distance: float = float('inf')  # [m] pairs farther apart were not reported
    pairs: list[RecordedPairs] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)
    changes: list[FilterChange] = field(default_factory=list)
    events: list[RuleEvent] = field(default_factory=list)
    cycle_seconds: list[float] = field(default_factory=list)
    filtered_pairs: int | None = None  # as get_filters said last
    start: float = 0.0  # the stamp [s] of the first result
    depth_of: dict[tuple[float, int, int], float] = field(default_factory=dict)
    least: float = np.inf  # [m] the smallest distance so far that is worth a picture
    approach: Approach | None = None

    @property
    def between(self) -> tuple[str, str] | None:
        """The sources of the first two robots, None where there are no two."""
        return (self.robots[0], self.robots[1]) if len(self.robots) >= 2 else None

    def add_distances(
        self,
        time: float,
        age: float,
        id_a: NDArray[np.int64],
        id_b: NDArray[np.int64],
        distance: Floats,
        error_bound: Floats,
        method: NDArray[np.uint8],
    ) -> None:
        """Keep the closest pairs of a result with the stamp ``time`` [s]."""
        order = np.argsort(distance, kind='stable')
        things: dict[str, int] = {}
        for k in order.tolist():
            things.setdefault(self.scene.pair_name(id_a[k], id_b[k]), k)
            if len(things) == CLOSEST_KEPT:
                break
        closest = list(things.values())
        between = distance[self._pictured(id_a, id_b)].min(initial=np.inf)
        if not self.pairs:
            self.start = time
        self.pairs.append(
            RecordedPairs(
                time,
                id_a[closest],
                id_b[closest],
                distance[closest],
                error_bound[closest],
                method[closest],
                age,
                float(between),
            )
        )
        if len(self.pairs) > RESULTS_KEPT:
            self._forget_half()

    def add_penetrations(
        self, time: float, id_a: NDArray[np.int64], id_b: NDArray[np.int64], depth: Floats
    ) -> None:
        """Keep the depths of a result with the stamp ``time`` [s]."""
        pairs = zip(id_a.tolist(), id_b.tolist(), depth.tolist(), strict=True)
        self.depth_of.update({(time, a, b): d for a, b, d in pairs})
        if len(depth) == 0:
            self.contacts.append(Contact(time, 0.0))
            return
        k = int(np.argmax(depth))
        self.contacts.append(Contact(time, float(depth[k]), int(id_a[k]), int(id_b[k])))

    def closer(
        self, id_a: NDArray[np.int64], id_b: NDArray[np.int64], distance: Floats
    ) -> int | None:
        """Return the index of the closest pair of the two robots where none was closer before."""
        wanted = np.flatnonzero(self._pictured(id_a, id_b))
        if not wanted.size:
            return None
        k = int(wanted[np.argmin(distance[wanted])])
        if distance[k] >= self.least:
            return None
        self.least = float(distance[k])
        return k

    def _forget_half(self) -> None:
        """Forget the older half of the results, but neither the changes nor the approach."""
        del self.pairs[: RESULTS_KEPT // 2]
        oldest = self.pairs[0].time
        self.contacts = [contact for contact in self.contacts if contact.time >= oldest]
        self.events = [event for event in self.events if event.time >= oldest]
        self.depth_of = {k: depth for k, depth in self.depth_of.items() if k[0] >= oldest}
        del self.cycle_seconds[: -len(self.pairs)]

    def _pictured(self, id_a: NDArray[np.int64], id_b: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which pairs (n,) are of the two robots; of no robot with itself if there is one.

        A robot's own links are built close to each other.
        """
        if self.between is not None:
            return self.scene.between(id_a, id_b, self.between)
        pictured = np.ones(len(id_a), dtype=bool)
        for robot in self.robots:
            pictured &= ~self.scene.between(id_a, id_b, (robot, robot))
        return pictured


def percentiles(values: list[float]) -> tuple[float, float]:
    """Return the median and the 99th percentile, NaN for no values."""
    if not values:
        return float('nan'), float('nan')
    p50, p99 = np.percentile(values, [50.0, 99.0])
    return float(p50), float(p99)
