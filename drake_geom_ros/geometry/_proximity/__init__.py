"""Arrays in, arrays out: the arithmetic behind the queries (private).

A room answers one question and imports only rooms below it, from the ground: ``runtime``, then
``filters`` and ``kernels``, ``world``, ``near``, ``pairs``, then ``points``, ``derivatives`` and
``states``, and ``engine`` on top. ``kinds`` and ``tolerances`` are everybody's.

In: arrays.
Out: arrays, with certified error bounds.
May import: ``math``.
"""
