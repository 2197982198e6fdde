"""What a library is to the bench, and which are installed."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from types import ModuleType
from typing import Any, Protocol

from bench.peers.scenes import Floats

MODULES = ('ours', 'drake_side', 'mujoco_side', 'fcl_side', 'coal_side')


class Side(Protocol):
    """A scene in one library; each module of MODULES has its NAME and such a class.

    ``answers`` holds, by the name of a query, what asks it, reads all results as arrays and
    returns how many there are.
    """

    answers: dict[str, Callable[[], int]]

    def layout(self, poses: Floats) -> Any:
        """Return poses (n, 7), x y z [m] qx qy qz qw, as the library takes them; not timed."""

    def set_poses(self, poses: Any) -> None:
        """Pose all bodies."""


def installed() -> tuple[list[ModuleType], list[str]]:
    """Return the modules of the libraries that are there, and lines about those that are not."""
    modules, missing = [], []
    for name in MODULES:
        try:
            modules.append(importlib.import_module(f'bench.peers.{name}'))
        except ImportError as error:
            if name == 'ours':
                raise
            missing.append(f'not installed here, left out: {name.removesuffix("_side")} ({error})')
    return modules, missing
