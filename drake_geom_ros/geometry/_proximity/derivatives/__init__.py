"""What distances do when bodies move.

In: rows of answers, and where everything was then.
Out: gradients by the motions of both bodies, whether they are the only ones, the features that
    touch.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``world``, ``filters``, ``near``,
    ``report``, ``pairs``; numpy.
"""
