"""Questions to an engine in one call each, as a query object asks them."""

from drake_geom_ros.geometry._proximity.engine.pair_query import ANSWERS, CANDIDATES, CONTACT
from drake_geom_ros.geometry._proximity.pairs.answer_rows import batch_of


def signed_distances(engine, world, filters, accuracy, cutoff, penetrating=False, time_budget=0.0):
    """Return the unfiltered pairs within ``cutoff`` [m], or only those that overlap."""
    prepared = engine.prepared(world, filters, accuracy, cutoff, penetrating, ANSWERS)
    return batch_of(engine.answer_of(prepared, time_budget))


def has_overlap(engine, world, filters, accuracy):
    """Return whether ``signed_distances`` would return a pair that overlaps."""
    return engine.finds_overlap(engine.prepared(world, filters, accuracy, 0.0, True, CONTACT))


def candidates(engine, world, filters, distance):
    """Return the unfiltered pairs (k, 2) that bounds alone do not keep apart."""
    return engine.candidates_of(
        engine.prepared(world, filters, 'bound', distance, False, CANDIDATES)
    )
