"""Meshcat's common calls over the page of this package, for scripts that come from Drake.

Names are those of ``pydrake.geometry``, so porting such a script means changing an import.
"""

from drake_geom_ros.viewing.meshcat.meshcat import Meshcat, MeshcatParams, StartMeshcat

__all__ = ['Meshcat', 'MeshcatParams', 'StartMeshcat']
