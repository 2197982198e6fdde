"""Access to the compiler and its cache for packages outside ``geometry``."""

from drake_geom_ros.geometry._proximity.runtime.compiled import Entry, Tell, compiled, given, like

__all__ = ['Entry', 'Tell', 'compiled', 'given', 'like']
