"""The cycle of a query, top to bottom: candidates, filter, kernels, rows of numbers."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.broadphase import candidate_pairs
from drake_geom_ros.geometry._proximity.filter_state import FilterState
from drake_geom_ros.geometry._proximity.kernels import calling
from drake_geom_ros.geometry._proximity.kernels.calling import DISTANCE, METHOD, PAIR_WIDTH
from drake_geom_ros.geometry._proximity.narrow_phase import (
    ADDRESSES,
    bound_phase,
    compile_rows,
    narrow_phase,
    point_phase,
    table_rows,
)
from drake_geom_ros.geometry._proximity.pair_table import SPHERE
from drake_geom_ros.geometry._proximity.tolerances import LEVEL_GAPS, TOUCHING_DEPTH
from drake_geom_ros.geometry._proximity.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

ACCURACY_LEVELS = ('bound', *LEVEL_GAPS)
# How a pair was answered: name and number, as in the messages.
METHODS = {
    'closed_form': calling.CLOSED_FORM,
    'iterative': calling.ITERATIVE,
    'mesh': calling.MESH,
    'bound_only': calling.BOUND_ONLY,
}
_METHOD_NAMES = {number: name for name, number in METHODS.items()}


@dataclass
class Effects:
    """What a query did and skipped: counts and seconds."""

    frames_moved: int = 0
    geometries_updated: int = 0
    broadphase_pairs: int = 0
    filtered_pairs: int = 0
    narrowphase_pairs: int = 0
    pairs_by_method: dict[str, int] = field(default_factory=dict)
    kernels_compiled: list[str] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)


class PairBatch:
    """The answers of one query: index pairs (k, 2) into the world, and their result rows."""

    def __init__(self, world: World, pairs: Indices, rows: Floats) -> None:
        self.world = world
        self.pairs = pairs
        self.rows = rows

    def where(self, keep: NDArray[np.bool_]) -> PairBatch:
        """Return the batch of the pairs in ``keep`` (k,)."""
        return PairBatch(self.world, self.pairs[keep], self.rows[keep])

    def penetrating(self) -> NDArray[np.bool_]:
        """Return which pairs overlap by more than touching, that is by more than rounding."""
        radii = self.world.outer_radii[self.pairs]
        # A half space has no size of its own: the pair's size is the other body's.
        sizes = np.where(np.isfinite(radii), radii, 0.0).sum(axis=1)
        return self.rows[:, DISTANCE] < -TOUCHING_DEPTH * sizes  # type: ignore[no-any-return]


@dataclass(frozen=True)
class PointBatch:
    """The answers of a point query: k rows, each of a point and a geometry by index."""

    world: World
    p_WQs: Floats  # (m, 3) [m]
    points: Indices  # (k,)
    geometries: Indices  # (k,)
    rows: Floats


class Engine:
    """Answers pair queries on a world under the filters, and tells what that took."""

    def __init__(self) -> None:
        self.effects = Effects()

    def prepare(self, world: World) -> list[str]:
        """Compile the kernels of the shape pairs that the world has; return their names."""
        types = np.unique(world.geometries.types)
        return compile_rows(table_rows(types[:, None], types[None, :]))

    def candidates(self, world: World, filters: FilterState, max_distance: float) -> Indices:
        """Return the unfiltered pairs (k, 2) that bounds alone do not keep apart."""
        self.effects = effects = Effects()
        start = time.perf_counter()
        effects.frames_moved, effects.geometries_updated = world.update()
        posed = time.perf_counter()
        pairs = candidate_pairs(world, max_distance)
        swept = time.perf_counter()
        effects.broadphase_pairs = len(pairs)
        slots = filters.slots(world.geometries.ids)
        pairs = pairs[filters.mask(slots[pairs[:, 0]], slots[pairs[:, 1]])]
        effects.filtered_pairs = effects.broadphase_pairs - len(pairs)
        effects.seconds = {
            'update': posed - start,
            'broadphase': swept - posed,
            'filter': time.perf_counter() - swept,
        }
        return pairs

    def signed_distances(
        self, world: World, pairs: Indices, accuracy: str, cutoff: float
    ) -> PairBatch:
        """Return the signed distance of ``pairs``; beyond ``cutoff`` [m] a bound may do.

        Two half spaces have no signed distance: such a pair is left out.
        """
        start = time.perf_counter()
        table = world.geometries
        types = table.types[pairs]
        rows = table_rows(types[:, 0], types[:, 1])
        if (rows < 0).any():
            pairs, types, rows = pairs[rows >= 0], types[rows >= 0], rows[rows >= 0]
        names = compile_rows(rows)
        compiled = time.perf_counter()
        results = np.zeros((len(pairs), PAIR_WIDTH))
        scene = (table.starts, table.pool, world.R_WGs, world.p_WGs)
        sizes = (world.outer_radii, world.inner_radii)
        if accuracy == 'bound':
            bound_phase(pairs, table.types, scene, sizes, results)
        else:
            gap = LEVEL_GAPS[accuracy]
            swapped = types[:, 0] > types[:, 1]
            narrow_phase(
                *(ADDRESSES, rows, pairs, swapped, table.types, scene, sizes),
                *(gap, cutoff, results),
            )
        self._note(names, results, start, compiled)
        return PairBatch(world, pairs, results)

    def point_distances(self, world: World, p_WQs: Floats, threshold: float) -> PointBatch:
        """Return the signed distances of all geometries to points (m, 3) up to ``threshold``."""
        self.effects = Effects()
        start = time.perf_counter()
        self.effects.frames_moved, self.effects.geometries_updated = world.update()
        table = world.geometries
        rows = table_rows(np.full_like(table.types, SPHERE), table.types)
        names = compile_rows(rows)
        compiled = time.perf_counter()
        capacity = len(p_WQs) * len(rows)
        results = np.zeros((capacity, PAIR_WIDTH))
        points, geometries = np.empty(capacity, np.int64), np.empty(capacity, np.int64)
        scene = (table.starts, table.pool, world.R_WGs, world.p_WGs)
        sizes = (world.outer_radii, world.inner_radii)
        count = point_phase(
            *(ADDRESSES, rows, table.types, p_WQs, scene, sizes),
            *(threshold, results, points, geometries),
        )
        self._note(names, results[:count], start, compiled)
        return PointBatch(world, p_WQs, points[:count], geometries[:count], results[:count])

    def _note(self, names: list[str], results: Floats, start: float, compiled: float) -> None:
        """Add to the effects what the narrow phase did."""
        effects = self.effects
        effects.kernels_compiled = names
        effects.narrowphase_pairs = len(results)
        methods, counts = np.unique(results[:, METHOD].astype(np.int64), return_counts=True)
        effects.pairs_by_method = {
            _METHOD_NAMES[m]: int(c)
            for m, c in zip(methods.tolist(), counts.tolist(), strict=True)
        }
        effects.seconds['compile'] = compiled - start
        effects.seconds['narrowphase'] = time.perf_counter() - compiled
