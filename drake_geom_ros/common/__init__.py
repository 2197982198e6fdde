"""Small values of general use, with the public names of ``pydrake.common`` that geometry needs."""

from drake_geom_ros.common.memory_file import MemoryFile

__all__ = ['MemoryFile']
