"""The decorators of this room's compiled code, whose caches are its own."""

from pathlib import Path

from drake_geom_ros.geometry._proximity.runtime.compiled import Room

SOURCES = (Path(__file__).parent,)  # and those of ``_proximity``: their folder holds this one
ROOM = Room('stops', SOURCES)
compiled, inlined = ROOM.compiled, ROOM.inlined
