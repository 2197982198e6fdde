"""The program ``drake_geom_ros``, or ``python -m drake_geom_ros``: one subcommand a module."""

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
from drake_geom_ros.command_line.unforeseen import UNFORESEEN, tell_unforeseen
from drake_geom_ros.geometry import GeometryError

BAD_INPUT = 2  # the exit code of what was asked wrongly, as argparse has it
_READER_LEFT = 141  # as a shell reports a process that SIGPIPE ended


def main(arguments: Sequence[str] | None = None, prog: str = 'drake_geom_ros') -> int:
    """Run the subcommand that the arguments name and return the exit code.

    ``prog`` is how it was started, as its help shows it.

    0: done; 1: ``check`` found the scene bad or python-fcl disagrees, ``replay`` finds the promise
    still broken or the disagreement still there, ``report`` that not all is known; 2: what was
    asked cannot be, said in one line on standard error; 3: ``report --audit`` refutes what a node
    said; 4: ``report --compare`` finds a run nearer than the other one; 70: an error that nobody
    foresaw, with its traceback on standard error; 130: interrupted.
    """
    try:
        options = _parser(prog).parse_args(arguments)
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # Whoever read has what it wanted. Python flushes once more at its end: into nothing.
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
        tell_unforeseen()
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
