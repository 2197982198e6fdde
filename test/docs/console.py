"""Console blocks of the docs: commands, and what they print."""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys

from drake_geom_ros.command_line.program import main

PROGRAM = 'python -m drake_geom_ros'
NUMBER = re.compile(r'-?\d+(?:\.\d+)?(?:e[-+]?\d+)?')


def blocks(text):
    """Return the console blocks of a text, each a list of (command, expected output)."""
    found = []
    for block in re.findall(r'^```console\n(.*?)^```$', text, re.S | re.M):
        parts = re.split(r'^\$ (.*)\n', block, flags=re.M)[1:]
        found.append(list(zip(parts[::2], parts[1::2], strict=True)))
    return found


def run(command, folder):
    """Return what a command prints, errors too.

    Our own program runs in this process, whose kernels are loaded, unless the shell has a part.
    """
    program = f'{PROGRAM} '
    if command.startswith(program) and not set(command) & set('|<>&;$*'):
        return in_this_process(shlex.split(command.removeprefix(program)), folder)
    done = subprocess.run(
        ['bash', '-c', command.replace('python -m', f'{sys.executable} -m', 1)],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=240,
    )
    return done.stdout


def in_this_process(arguments, folder):
    """Return what our program prints in a folder."""
    before, printed = os.getcwd(), io.StringIO()
    os.chdir(folder)
    try:
        with (
            contextlib.redirect_stdout(printed),
            contextlib.redirect_stderr(printed),
            contextlib.suppress(SystemExit),  # of arguments that are none
        ):
            main(arguments, prog=PROGRAM)
    finally:
        os.chdir(before)
    return printed.getvalue()


def words_and_numbers(text):
    """Return a text without its numbers, and the numbers."""
    return NUMBER.sub('#', text), [float(number) for number in NUMBER.findall(text)]
