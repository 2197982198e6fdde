"""The narrow phase: distance or depth of each pair of the list, with its error bound.

Enters: pairs with their slots, a world, the level's gap and the cutoff [m]. Leaves: rows of
answers. ``narrow_phase`` is the loop, ``error_bounds`` what a level promises, ``budgeted`` the
same in blocks while time lasts. Imports ``kernels``, ``world`` and ``runtime``.
"""
