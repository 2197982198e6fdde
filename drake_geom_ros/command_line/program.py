"""Program ``drake_geom_ros``, or ``python -m drake_geom_ros``; each subcommand is a module.

Only the module of the command that runs is imported: help and completion take no geometry.
"""

import errno
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from drake_geom_ros.command_line.exit_codes import (
    BAD_INPUT,
    INTERRUPTED,
    UNFORESEEN,
    print_unforeseen,
)
from drake_geom_ros.command_line.spread_options import spread
from drake_geom_ros.command_line.standard_input import STANDARD_INPUT
from drake_geom_ros.program_parser import ProgramParser
from drake_geom_ros.version import VERSION

COMMANDS = {
    'query': 'ask about a scene',
    'batch': 'ask about many states of a scene, on all cores or a cluster',
    'check': 'load a scene and list what it has',
    'check-motion': 'whether a whole path or motion is clear, certified for all times',
    'suggest-filters': 'find out which pairs of links of a robot to filter',
    'convert': 'convert a URDF to a scene file, a pose file or a sensed map to another format',
    'render': 'take images of a scene',
    'view': 'show a scene in the browser',
    'replay': 'compute again what a node wrote to a file for that',
    'report': 'report the distances of a recorded run',
    'compile': 'compile what queries run, before anybody waits for it',
    'completion': 'print the completion script for bash, zsh or tcsh',
}


def load(words: Sequence[str]) -> None:
    """Import what the command among the arguments needs, which takes longest."""
    if words and words[0] in COMMANDS:
        _module_of(words[0])


def main(
    arguments: Sequence[str] | None = None,
    prog: str = 'drake_geom_ros',
    others: Mapping[str, str] | None = None,
) -> int:
    """Run the subcommand that the arguments name and return one of ``exit_codes``.

    ``prog`` is the name of the program in its help, ``others`` are further commands in it, with
    their help, which the caller runs.
    """
    words = spread(sys.argv[1:] if arguments is None else arguments)
    try:
        parser = parser_of(prog, others or {}, words[:1])
        parser.refuse_empty(words)
        options = parser.parse_args(words)
        if list(vars(options).values()).count(STANDARD_INPUT) > 1:
            parser.error(f'{STANDARD_INPUT!r} is the standard input, which can be one file only')
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        raise  # to ``programs``: the reader has left, which is no error of the input
    except KeyboardInterrupt:
        print('drake_geom_ros: interrupted', file=sys.stderr)
        return INTERRUPTED
    except Exception as error:
        if not _is_of_input(error):
            print_unforeseen()
            return UNFORESEEN
        print(f'drake_geom_ros: {_reason(error)}', file=sys.stderr)
        return BAD_INPUT


def parser_of(prog: str, others: Mapping[str, str], chosen: Sequence[str]) -> ProgramParser:
    """Return the parser of the program, with the arguments of the chosen commands alone."""
    parser = ProgramParser(
        prog=prog,
        description='Answers about a scene file, without ROS; with ROS 2 the node, and what looks '
        'at it.',
        epilog=f'Each command explains itself: {prog} query --help.',
    )
    parser.add_argument('--version', action='version', version=f'drake_geom_ros {VERSION}')
    parser.set_defaults(others=others)
    for word in chosen:
        parser.refuse_unknown_option(word)
    all_commands = {**COMMANDS, **others}
    if chosen and chosen[0] not in all_commands and not chosen[0].startswith('-'):
        from drake_geom_ros.common.nearest import nearest

        meant = nearest(chosen[0], all_commands) or f'; there are {", ".join(all_commands)}'
        parser.error(f'there is no command {chosen[0]!r}{meant}')
    commands: Any = parser.add_subparsers(title='commands', metavar='COMMAND', required=True)
    for name, words in all_commands.items():
        if name in chosen and name in COMMANDS:
            # Shells complete commands that have a help.
            _module_of(name).add_to(
                SimpleNamespace(add_parser=partial(commands.add_parser, help=words))
            )
        else:
            commands.add_parser(name, help=words)
    return parser


def _module_of(command: str) -> Any:
    return import_module(f'drake_geom_ros.command_line.{command.replace("-", "_")}')


def _reason(error: Exception) -> str:
    """Return what an error says, in one line; of a file the name first, and its missing folder."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        folder = Path(error.filename).parent
        if error.errno == errno.ENOENT and not folder.exists():
            return f'{error.filename}: there is no folder {folder}'
        return f'{error.filename}: {error.strerror[0].lower()}{error.strerror[1:]}'
    return ' '.join(str(error).split())


def _is_of_input(error: Exception) -> bool:
    """Return whether an error is about what the user gave, and no fault of the program."""
    from drake_geom_ros.geometry import GeometryError

    return isinstance(error, (GeometryError, OSError))
