"""How closely recordings are judged where nobody says."""

CERTIFIED = 0.001  # [m] bounds of motions are no farther than that below what is seen
NEARER_BY = 0.001  # [m] so much nearer than another run comes one that is not told
SAME = 1e-9  # [m] and [-] numbers of a pose that was written and read again
NEAR = 1e-6  # [m] and [-] that recorded witnesses may be off, beside their error bounds
