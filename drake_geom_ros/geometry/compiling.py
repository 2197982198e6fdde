"""What compiles code of rooms outside ``geometry``: with its options, in its cache."""

from drake_geom_ros.geometry._proximity.runtime.compiled import Entry, compiled, given, like

__all__ = ['Entry', 'compiled', 'given', 'like']
