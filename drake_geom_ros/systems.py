"""``pydrake.systems`` is not rebuilt here: the import fails and names the page about porting."""

raise ImportError(
    'drake_geom_ros has no systems: pydrake.systems is not rebuilt here. pydrake.systems.sensors '
    'is drake_geom_ros.sensors, and SceneGraph has the ports that geometry needs; '
    'docs/differences_from_pydrake.md shows how to port a script',
    name=__name__,
)
