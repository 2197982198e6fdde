"""What distances do when bodies move.

Enters: rows of answers, and where everything was when they were computed. Leaves: gradients by
the motions of both bodies, whether they are the only ones, and the features that touch. Imports
``pairs``, ``kernels``, ``world`` and ``runtime``.
"""
