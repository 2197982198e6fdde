"""Default tolerances for judging recordings."""

CERTIFIED = 0.001  # [m] distance of certified bounds of motions to distances at states
NEARER_BY = 0.001  # [m] a run may come this much nearer than the other without an exit code
SAME = 1e-9  # [m] and [-] difference of a pose that was written and read again
NEAR = 1e-6  # [m] and [-] error of recorded witnesses, in addition to their error bounds
