"""``pydrake.multibody`` is not rebuilt here: the import fails and names the page about porting."""

raise ImportError(
    'drake_geom_ros has no multibody: pydrake.multibody is not rebuilt here. '
    'trajectories.Kinematics has forward kinematics, and optimization the constraints on '
    'distances; docs/differences_from_pydrake.md shows how to port a script',
    name=__name__,
)
