"""The narrow phase: distance or depth of each pair of the list, with its error bound.

``narrow_phase`` is the loop, ``error_bounds`` what a level promises, ``budgeted`` the same in
blocks while time lasts.

In: pairs with their slots, a world, the level's gap and the cutoff [m].
Out: rows of answers.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``world``, ``filters``, ``near``,
    ``report``; numpy.
"""
