"""Scenes that a Python program builds with pydrake or MuJoCo, as inputs of ``convert``."""

from __future__ import annotations

import re
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import LoadedScene, SceneFileError, from_mujoco, from_pydrake

_CALL = re.compile(r'(?P<file>.+\.py):(?P<function>[A-Za-z_]\w*)')
_MEANT = 'a Diagram or a SceneGraph of pydrake, or an mujoco.MjModel'


class BuildCall(NamedTuple):
    """A function of a Python file that builds a scene."""

    file: Path
    function: str


def build_call(text: str) -> BuildCall | None:
    """Return the function that ``FILE.py:FUNCTION`` names, None for another text."""
    call = _CALL.fullmatch(text)
    return None if call is None else BuildCall(Path(call['file']), call['function'])


def load_built(call: BuildCall, scene_graph: SceneGraph) -> LoadedScene:
    """Register what a function builds, and return the ids by name.

    The file is run, and then the function without arguments. Of a diagram of pydrake, frames have
    the poses of its default context. Raises SceneFileError for a function that is not there, that
    fails, or that returns something else; errors as ``from_pydrake`` and ``from_mujoco``.
    """
    built = _built(call)
    if type(built).__name__ == 'MjModel':
        return from_mujoco(built, scene_graph)
    if hasattr(built, 'model_inspector'):
        return from_pydrake(built, scene_graph)
    systems = built.GetSystems() if hasattr(built, 'GetSystems') else []
    graphs = [system for system in systems if hasattr(system, 'model_inspector')]
    if len(graphs) != 1:
        has = f'a diagram of {len(graphs)} scene graphs' if systems else repr(built)
        raise SceneFileError(
            f'{call.function} returned {has}; it returns {_MEANT}', str(call.file)
        )
    context = graphs[0].GetMyContextFromRoot(built.CreateDefaultContext())
    query_object = graphs[0].get_query_output_port().Eval(context)
    return from_pydrake(graphs[0], scene_graph, query_object)


def _built(call: BuildCall) -> Any:
    """Return the result of a function of a file."""
    if not call.file.is_file():
        raise SceneFileError('there is no such file', str(call.file))
    try:
        function: Callable[[], Any] | None = runpy.run_path(str(call.file)).get(call.function)
    except Exception as error:
        raise SceneFileError(f'cannot be run: {error!r}', str(call.file)) from error
    if not callable(function):
        raise SceneFileError(f'has no function {call.function!r}', str(call.file))
    try:
        return function()
    except Exception as error:
        raise SceneFileError(f'{call.function} failed: {error!r}', str(call.file)) from error
