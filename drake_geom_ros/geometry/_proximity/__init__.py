"""Arithmetic of the queries (private): arrays in, arrays with certified error bounds out.

From the ground up: ``runtime``, then ``filters`` and ``kernels``, ``world``, ``near``, ``pairs``,
then ``points``, ``derivatives``, ``states`` and ``motion``, and ``engine`` on top. Every package
may use ``kinds`` and ``tolerances``. Each answers one question, see ``docs/contributing.md``.
"""
