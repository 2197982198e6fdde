"""The decorator for compiled code of rooms outside ``geometry``: its options and its cache."""

from drake_geom_ros.geometry._proximity.runtime.compiled import compiled

__all__ = ['compiled']
