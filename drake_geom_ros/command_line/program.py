"""Program ``drake_geom_ros``, or ``python -m drake_geom_ros``; each subcommand is a module."""

import argparse
import os
import sys
from collections.abc import Sequence

from drake_geom_ros.command_line import (
    batch,
    check,
    check_motion,
    compile,
    convert,
    query,
    render,
    replay,
    report,
    suggest_filters,
    view,
)
from drake_geom_ros.command_line.unforeseen import UNFORESEEN, print_unforeseen
from drake_geom_ros.geometry import GeometryError

BAD_INPUT = 2  # exit code of wrong arguments, as of argparse
_READER_LEFT = 141  # exit code, as shells report SIGPIPE


def main(arguments: Sequence[str] | None = None, prog: str = 'drake_geom_ros') -> int:
    """Run the subcommand that the arguments name and return the exit code.

    ``prog`` is the name of the program in its help. Exit codes are

    - 0: done;
    - 1: ``check`` finds the scene invalid or python-fcl disagrees, ``replay`` still exceeds the
      tolerance or still disagrees, ``report`` has reservations;
    - 2: invalid arguments or input, reported in one line on standard error;
    - 3: ``report --audit`` refutes a node;
    - 4: ``report --compare`` finds the run nearer than the other one;
    - 70: an internal error, with its traceback on standard error;
    - 130: interrupted.
    """
    try:
        options = _parser(prog).parse_args(arguments)
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # The reader closed the pipe. Python flushes once more at exit, so give it another file.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _READER_LEFT
    except KeyboardInterrupt:
        print('drake_geom_ros: interrupted', file=sys.stderr)
        return batch.INTERRUPTED
    except (GeometryError, OSError) as error:
        reason = ' '.join(str(error).split())
        print(f'drake_geom_ros: {reason}', file=sys.stderr)
        return BAD_INPUT
    except Exception:
        print_unforeseen()
        return UNFORESEEN


def _parser(prog: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=prog,
        description='Answers about a scene file, without ROS.',
        epilog=f'Each command explains itself: {prog} query --help.',
    )
    commands = parser.add_subparsers(title='commands', metavar='COMMAND', required=True)
    for module in (
        query,
        batch,
        check,
        check_motion,
        suggest_filters,
        convert,
        render,
        view,
        replay,
        report,
        compile,
    ):
        module.add_to(commands)
    return parser
