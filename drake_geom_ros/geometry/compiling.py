"""Access to the compiler and its cache for packages outside ``geometry``."""

from drake_geom_ros.geometry._proximity.runtime.compiled import Entry, compiled, given, like

__all__ = ['Entry', 'compiled', 'given', 'like']
