"""Check that VTK can draw on this machine, in a child, since it crashes without its libraries."""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import os
import subprocess
import sys

_PATIENCE = 120.0  # [s] of a first import, from a slow disk or on a busy machine
_TELLING = 'drawn'
# An empty picture suffices, since the creation of the context is what crashes.
_PROBE = f"""
from vtkmodules.vtkRenderingCore import vtkRenderer
from drake_geom_ros.geometry.render.vtk.windows import hidden_window
window = hidden_window()
window.AddRenderer(vtkRenderer())
window.Render()
print('{_TELLING}' if window.SupportsOpenGL() else 'no OpenGL')
"""
# Libraries that VTK opens at run time, and the Debian packages of them and of their drivers.
_LIBRARIES = {'libEGL.so.1': 'libegl1', 'libEGL_mesa.so.0': 'libegl-mesa0'}
_PACKAGES = 'libegl1 libgl1-mesa-dri'


@functools.cache
def why_not() -> str:
    """Return why VTK cannot draw here and what to install, empty if it can.

    The result is cached for the process. A child tries it, which takes about a second.
    """
    if importlib.util.find_spec('vtkmodules') is None:
        return (
            "vtk is not installed: pip install vtk, or this package with its extra 'vtk'; "
            'MakeRenderEngineExact needs no graphics library'
        )
    try:
        child = subprocess.run(
            [sys.executable, '-c', _PROBE],
            env={**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path))},
            capture_output=True,
            text=True,
            timeout=_PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return (
            f'VTK has drawn nothing within {_PATIENCE:g} s: the machine is too busy, or its '
            'driver hangs; try again, or use MakeRenderEngineExact, which needs no such library'
        )
    if child.returncode == 0 and child.stdout.split('\n')[-2:-1] == [_TELLING]:
        return ''
    missing = [f'{name} ({package})' for name, package in _LIBRARIES.items() if not _opens(name)]
    not_found = f'not found: {", ".join(missing)}; ' if missing else ''
    how = f'signal {-child.returncode}' if child.returncode < 0 else 'an error'
    return (
        f'VTK cannot draw on this machine: a process that tried ended by {how}; {not_found}'
        f'install its system libraries (apt-get install {_PACKAGES}), or use '
        'MakeRenderEngineExact, which needs none'
    )


def _opens(library: str) -> bool:
    """Return whether a shared library can be opened."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
