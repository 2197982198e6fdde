"""Shells that have sourced `run` of a folder of its own, and steps without their work."""

import os
import shutil
import subprocess
import sys
import time

import pytest
from conventions.source_tree import ROOT

# The steps without their work: each tells that it ran, and makes what the next one looks for.
FAKE_STEPS = """
check_system() { :; }
make_venv() { echo venv >>"$root/calls"; mkdir -p "$venv"; }
install_tools() { echo tools >>"$root/calls"; }
install_packages() { echo packages >>"$root/beside"; }
build_messages() { echo messages >>"$root/calls"; mkdir -p "$prefix"; }
build_tf2_msgs() { echo tf2_msgs >>"$root/calls"; }
compile_kernels() { echo kernels >>"$root/beside"; }
compile_all() { echo others >>"$root/others"; }
install_test() { :; }
"""


@pytest.fixture
def folder(tmp_path):
    """Return a folder with what the keys of the steps are computed from, and what is sourced."""
    for name in ('run', 'setup.py'):
        shutil.copy(ROOT / name, tmp_path)
    for given in ('requirements', 'config'):
        shutil.copytree(ROOT / given, tmp_path / given)
    for definitions in ('msg_defs', 'test/msg_defs'):
        shutil.copytree(ROOT / definitions, tmp_path / definitions)
    return tmp_path


def start(folder, script, **variables):
    """Start a shell that has sourced `run` of a folder, in a session of its own."""
    environment = {'PATH': os.environ['PATH'], 'PYTHON': sys.executable, **variables}
    return subprocess.Popen(
        ['bash', '-c', f'source ./run\n{script}'],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def shell(folder, script, **variables):
    """Return (exit code, output, errors) of a script after `run` was sourced."""
    process = start(folder, script, **variables)
    output, errors = process.communicate(timeout=800)
    return process.returncode, output, errors


def calls(folder):
    return (folder / 'calls').read_text().split()


def ended(folder):
    """Return whether what is busy beside has ended, or does within a minute."""
    for _ in range(600):
        try:
            os.kill(int((folder / 'busy').read_text()), 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False
