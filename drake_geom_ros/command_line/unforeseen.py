"""Errors that are faults of this program, and not of what it was asked."""

import sys
import traceback

UNFORESEEN = 70  # the exit code, as sysexits.h has it for an internal error


def tell_unforeseen(name: str = 'drake_geom_ros') -> None:
    """Print the exception that is handled, with its traceback, on standard error."""
    error = sys.exc_info()[1]
    traceback.print_exc()
    print(
        f'{name}: an error that nobody foresaw, {type(error).__name__}: please report it with the '
        'lines above',
        file=sys.stderr,
    )
