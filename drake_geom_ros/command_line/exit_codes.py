"""The exit codes of all commands, for scripts that decide by them, and the report of a fault."""

import sys
import traceback

DONE = 0
NO = 1  # what was checked does not hold, or the answer has reservations
BAD_INPUT = 2  # arguments or files, reported in one line on standard error; as of argparse
NOT_PROVED = 3  # `check-motion`: clear in pieces only; `report --audit`: a node is refuted
NEARER = 4  # `report --compare`: nearer than the other run
UNFORESEEN = 70  # an internal error, with its traceback; as in sysexits.h
INTERRUPTED = 130  # as shells report SIGINT
READER_LEFT = 141  # as shells report SIGPIPE


def print_unforeseen(name: str = 'drake_geom_ros') -> None:
    """Print the handled exception with its traceback on standard error."""
    error = sys.exc_info()[1]
    traceback.print_exc()
    print(
        f'{name}: an error that nobody foresaw, {type(error).__name__}: please report it with the '
        'lines above',
        file=sys.stderr,
    )
