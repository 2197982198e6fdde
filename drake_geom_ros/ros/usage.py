"""Help of programs whose arguments are ROS parameters."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

_HELP = {'-h', '--help'}


def is_help(words: Sequence[str] | None) -> bool:
    """Return whether arguments, by default those of the process, ask for help."""
    return bool(_HELP & set(sys.argv[1:] if words is None else words))


def usage(
    program: str, *, example: str, description: str, texts: Mapping[str, str], see: str
) -> str:
    """Return the help of a program with parameters of such texts.

    It is called ``program``, or as it was started where it is a command of ``drake_geom_ros``.
    """
    if sys.argv[0].startswith('drake_geom_ros '):
        program = sys.argv[0]
    width = max(map(len, texts)) + 2
    return '\n'.join(
        [
            f'usage: {program} --ros-args {example} ...',
            '',
            description,
            '',
            'parameters, each as -p NAME:=VALUE behind --ros-args:',
            *(f'  {name:{width}}{text}' for name, text in texts.items()),
            '',
            see,
        ]
    )
