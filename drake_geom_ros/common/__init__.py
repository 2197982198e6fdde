"""Small values of general use, with the public names of ``pydrake.common`` that geometry needs."""

from typing import TYPE_CHECKING

from drake_geom_ros.common.memory_file import MemoryFile
from drake_geom_ros.math.missing import refuse_missing

__all__ = ['MemoryFile']

if not TYPE_CHECKING:  # mypy would take any name for one that is there
    __getattr__ = refuse_missing(__name__)
