"""Effects of a query: the work it did and skipped, as counts and seconds."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Effects:
    """Work that a query did and skipped, as counts and seconds.

    ``broadphase_pairs = filtered_pairs + far_pairs + cached_pairs + narrowphase_pairs``, but in
    HasCollisions, which stops at the first contact.
    """

    frames_moved: int = 0
    geometries_updated: int = 0
    broadphase_pairs: int = 0  # near enough to be looked at
    filtered_pairs: int = 0
    far_pairs: int = 0  # too far apart, by their bounds or by how little they can have moved
    cached_pairs: int = 0  # answered from the last result, because both bodies rest
    narrowphase_pairs: int = 0  # computed, by a kernel or from bounds
    wide_pairs: int = 0  # whose bounds are wider than the level promises, though they hold
    unrefined_pairs: int = 0  # reported from bounds because the time budget was spent
    pairs_by_method: dict[str, int] = field(default_factory=dict)  # of these
    near_list_made: bool = False  # the broad phase ran
    kernels_compiled: list[str] = field(default_factory=list)
    # By step. The time of looking up known pairs is included in that of computing the others,
    # unless the context records detailed effects.
    seconds: dict[str, float] = field(default_factory=dict)


def seconds_by_step(
    begun: float,
    posed: float,
    listed: float,
    compiled: float,
    answered: float,
    filtering: float,
    knowing: float,
) -> dict[str, float]:
    """Return the seconds of each step, from the times [s] when they ended.

    Filtering and the look-up of known pairs are steps of their own.
    """
    return {
        'update': posed - begun,
        'broadphase': listed - posed - filtering,
        'filter': filtering,
        'compile': compiled - listed,
        'cache': knowing,
        'narrowphase': answered - compiled - knowing,
    }
