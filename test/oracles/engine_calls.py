"""Questions to an engine in one call each, as a query object asks them."""

import math

from drake_geom_ros.geometry._proximity.engine.pair_query import ANSWERS, CANDIDATES, CONTACT
from drake_geom_ros.geometry._proximity.pairs.answer_rows import batch_of
from drake_geom_ros.geometry._proximity.tolerances import GAPS_OF_LEVELS


def signed_distances(engine, world, filters, accuracy, cutoff, penetrating=False, time_budget=0.0):
    """Return the unfiltered pairs within ``cutoff`` [m], or only those that overlap."""
    level_gap = GAPS_OF_LEVELS[accuracy]
    prepared = engine.prepared(world, filters, level_gap, cutoff, penetrating, ANSWERS)
    return batch_of(engine.answer_of(prepared, time_budget))


def has_overlap(engine, world, filters, accuracy):
    """Return whether ``signed_distances`` would return a pair that overlaps."""
    query = world, filters, GAPS_OF_LEVELS[accuracy], 0.0, True, CONTACT
    return engine.finds_overlap(engine.prepared(*query))


def candidates(engine, world, filters, distance):
    """Return the unfiltered pairs (k, 2) that bounds alone do not keep apart."""
    return engine.candidates_of(
        engine.prepared(world, filters, math.inf, distance, False, CANDIDATES)
    )
