"""Console blocks of the docs: commands, and what they print."""

import re
import subprocess
import sys

NUMBER = re.compile(r'-?\d+(?:\.\d+)?(?:e[-+]?\d+)?')


def blocks(text):
    """Return the console blocks of a text, each a list of (command, expected output)."""
    found = []
    for block in re.findall(r'^```console\n(.*?)^```$', text, re.S | re.M):
        parts = re.split(r'^\$ (.*)\n', block, flags=re.M)[1:]
        found.append(list(zip(parts[::2], parts[1::2], strict=True)))
    return found


def run(command, folder):
    """Return what a command prints, errors too."""
    command = command.replace('python -m', f'{sys.executable} -m', 1)
    done = subprocess.run(
        ['bash', '-c', command],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=240,
    )
    return done.stdout


def words_and_numbers(text):
    """Return a text without its numbers, and the numbers."""
    return NUMBER.sub('#', text), [float(number) for number in NUMBER.findall(text)]
