"""Report of internal errors, which are faults of this program and not of its input."""

import sys
import traceback


def print_unforeseen(name: str = 'drake_geom_ros') -> None:
    """Print the handled exception with its traceback on standard error."""
    error = sys.exc_info()[1]
    traceback.print_exc()
    print(
        f'{name}: an error that nobody foresaw, {type(error).__name__}: please report it with the '
        'lines above',
        file=sys.stderr,
    )
