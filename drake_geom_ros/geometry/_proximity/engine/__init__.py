"""One query from top to bottom.

In: a world, filters, what is asked.
Out: arrays that no later change reaches, and the report of what was done.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``world``, ``filters``, ``near``,
    ``report``, ``pairs``, ``points``, ``derivatives``; numpy, numba.
"""
