"""Command ``completion``: print what makes a shell complete the commands and their options."""

import argparse
from importlib import import_module
from typing import Any

from drake_geom_ros.command_line import program
from drake_geom_ros.command_line.exit_codes import DONE
from drake_geom_ros.geometry import ArgumentError

PROGRAM = 'drake_geom_ros'


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'completion',
        description='Prints a completion script, for example: drake_geom_ros completion bash > '
        '~/.local/share/bash-completion/completions/drake_geom_ros',
    )
    parser.add_argument('shell', choices=('bash', 'zsh', 'tcsh'))
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the script and return the exit code; ArgumentError where the library is missing."""
    try:
        shtab: Any = import_module('shtab')
    except ImportError:
        raise ArgumentError(
            "completion needs shtab: pip install 'drake_geom_ros[completion]'"
        ) from None
    parser = program.parser_of(PROGRAM, options.others, tuple(program.COMMANDS))
    print(shtab.complete(parser, shell=options.shell))
    return DONE
