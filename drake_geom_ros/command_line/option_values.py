"""Numbers on the command line, refused with what they are and what is allowed."""

import argparse
import math
import re

from drake_geom_ros.geometry import ACCURACY_LEVELS, Accuracy, ArgumentError, accuracy_of

ACCURACY_HELP = f'{", ".join(ACCURACY_LEVELS)}, or the largest error [m] (default: exact)'


def number(text: str) -> float:
    """Return a number; ArgumentTypeError for what is none, or has a unit."""
    try:
        return float(text)
    except ValueError:
        pass
    if bare := re.fullmatch(r'([-+.\d]+(?:e[-+]?\d+)?) *([a-zA-Zµ°%]+)', text):
        raise argparse.ArgumentTypeError(
            f'{text!r} has a unit; write a number alone, such as {bare[1]} '
            '(lengths are [m], angles [rad], times [s])'
        )
    raise argparse.ArgumentTypeError(f'{text!r} is no number')


def finite(text: str) -> float:
    """Return a finite number."""
    value = number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f'{text!r} must be finite')
    return value


def distance(text: str) -> float:
    """Return a distance [m] >= 0, or inf."""
    value = number(text)
    if not value >= 0.0:
        raise argparse.ArgumentTypeError(f'{text!r} must be a distance >= 0 [m]')
    return value


def positive(text: str) -> float:
    """Return a finite number > 0."""
    value = finite(text)
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f'{text!r} must be > 0')
    return value


def count(text: str) -> int:
    """Return a whole number > 0."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f'{text!r} must be a whole number > 0')
    return int(text)


def count_or_zero(text: str) -> int:
    """Return a whole number >= 0."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f'{text!r} must be a whole number >= 0')
    return int(text)


def accuracy(text: str) -> Accuracy:
    """Return an accuracy; ArgumentTypeError for what is neither a level nor a length [m]."""
    try:
        return accuracy_of(text)
    except ArgumentError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
