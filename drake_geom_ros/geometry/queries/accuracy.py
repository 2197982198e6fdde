"""Accuracy of queries: the largest error that is wanted, a length in metres or a level's name."""

from __future__ import annotations

import functools
import math
from numbers import Real
from typing import Literal

from drake_geom_ros.geometry._proximity.tolerances import GAPS_OF_LEVELS
from drake_geom_ros.geometry.errors import ArgumentError

# Editors complete the names; a length may be text, too.
AccuracyLike = Literal['bound', 'fast', 'balanced', 'exact'] | str | float


class Accuracy(str):
    """An accuracy as text, as messages and files have it, with its ``length`` [m].

    The text is the name of a level or the length. For bodies that are apart, queries return an
    ``error_bound`` of at most this length, where rounding of their coordinates is less; that of
    ``bound`` is infinite.

    >>> Accuracy('1e-3'), Accuracy(1e-3).length, Accuracy('balanced').length
    ('0.001', 0.001, 1e-06)
    """

    length: float

    def __new__(cls, accuracy: AccuracyLike) -> Accuracy:
        """Return an accuracy.

        Args:
            accuracy: ``bound``, ``fast``, ``balanced``, ``exact``, or a length [m], also as text.

        Raises:
            ArgumentError: For another name, and for a length that is not positive and finite.
        """
        text, length = _parsed(accuracy)
        made = super().__new__(cls, text)
        made.length = length
        return made


def accuracy_of(accuracy: AccuracyLike) -> Accuracy:
    """Return the ``Accuracy`` of a name or a length; raises ArgumentError as it does."""
    if type(accuracy) is Accuracy:
        return accuracy
    return _made(accuracy) if isinstance(accuracy, (str, float)) else Accuracy(accuracy)


@functools.lru_cache(maxsize=64, typed=True)
def _made(accuracy: AccuracyLike) -> Accuracy:
    return Accuracy(accuracy)


def _parsed(accuracy: AccuracyLike) -> tuple[str, float]:
    """Return the text and the length [m] of an accuracy."""
    if isinstance(accuracy, str) and accuracy in GAPS_OF_LEVELS:
        return str(accuracy), GAPS_OF_LEVELS[accuracy]
    is_number = isinstance(accuracy, (str, Real)) and not isinstance(accuracy, bool)
    try:
        length = float(accuracy) if is_number else math.nan
    except ValueError:
        length = math.nan
    if not 0.0 < length < math.inf:
        allowed = ', '.join(GAPS_OF_LEVELS)
        raise ArgumentError(
            f'accuracy={accuracy!r} was asked for; it must be one of {allowed}, or a length in '
            'metres that is positive and finite, such as 1e-3'
        )
    return repr(length), length
