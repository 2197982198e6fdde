"""Many states of one scene, in compiled loops, each as if it was asked about alone.

In: a world of its own, pairs, poses (N, n, 7).
Out: answers by state, none of which enters the next.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``world``, ``filters``, ``near``,
    ``report``, ``pairs``, ``points``; numpy.
"""
