"""Arguments of programs, refused with what was meant."""

import argparse
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

_BAD_ARGUMENTS = 2  # exit code, as of argparse
_NO_NUMBER = re.compile(r'invalid (?:float|int) value: (.*)')


class ProgramParser(argparse.ArgumentParser):
    """Reports a wrong argument as all errors are reported, in one line below the usage."""

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse as argparse does, but let a command itself refuse an option that it has not.

        argparse leaves that to the parser of the program, which has no option of the command.
        """
        options, rest = super().parse_known_args(args, namespace)
        unknown = [word.partition('=')[0] for word in rest if word.startswith('--')]
        if unknown and self._subparsers is None:
            from drake_geom_ros.common.nearest import nearest

            meant = nearest(unknown[0], self._option_string_actions)
            self.error(f'there is no option {unknown[0]}{meant}')
        return options, rest

    def refuse_unknown_option(self, word: str) -> None:
        """End the process where an option is none of this parser's, nor the start of one.

        argparse asks for the command first, which a misspelt ``--version`` does not need.
        """
        name, options = word.partition('=')[0], self._option_string_actions
        if name.startswith('--') and not any(each.startswith(name) for each in options):
            from drake_geom_ros.common.nearest import nearest

            self.error(f'there is no option {name}{nearest(name, options)}')

    def refuse_empty(self, words: Sequence[str]) -> None:
        """End the process where an argument is empty, which would count as one not given."""
        for k, word in enumerate(words):
            name, equals, value = word.partition('=')
            if not word or (word.startswith('--') and equals and not value):
                which = name or (
                    words[k - 1] if k and words[k - 1].startswith('-') else 'argument'
                )
                self.error(f'{which}: an empty text; was a variable of the shell not set?')

    def error(self, message: str) -> NoReturn:
        """Print what is wrong and end the process with exit code 2."""
        self.print_usage(sys.stderr)
        message = _NO_NUMBER.sub(r'\1 is no number', message)
        self.exit(_BAD_ARGUMENTS, f'drake_geom_ros: {message}\n')
