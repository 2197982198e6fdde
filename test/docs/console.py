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


def commands(text):
    """Return the (command, expected output) pairs of a console block."""
    parts = re.split(r'^\$ ((?:.*\\\n)*.*)\n', text, flags=re.M)[1:]
    joined = [command.replace('\\\n', ' ') for command in parts[::2]]
    return list(zip(joined, parts[1::2], strict=True))


def run(command, folder):
    """Return the exit code of a command and what it prints, errors too.

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
        timeout=800,
    )
    return done.returncode, done.stdout


def in_this_process(arguments, folder):
    """Return the exit code of our program in a folder and what it prints."""
    before, printed = os.getcwd(), io.StringIO()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            code = main(arguments, prog=PROGRAM)
    except SystemExit as refused:  # arguments that the parser does not know
        code = refused.code
    finally:
        os.chdir(before)
    return code, printed.getvalue()


def words_and_numbers(text):
    """Return a text without its numbers, and the numbers."""
    return NUMBER.sub('#', text), [float(number) for number in NUMBER.findall(text)]
