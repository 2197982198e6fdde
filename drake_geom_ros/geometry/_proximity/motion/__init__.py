"""Whether a whole motion is clear, not only its samples: certified for all times.

In: a world of its own, pairs, a motion of frames or of joints, a least distance [m].
Out: clear, contact or unknown, with the times, bounds and pair that tell it.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``world``, ``filters``, ``near``,
    ``report``, ``pairs``, ``points``, ``states``; numpy.
"""
