"""References, judges and hard cases that tests and measurements share; no kernel is in them.

==================  ============================================================================
``bodies``          bodies to ask about: random ones, arms, grids, tori, meshes
``references``      signed distances in 50 digits, by searches over directions and by all triangles
``surfaces``        contact surfaces in closed form, and whether one fits those of poses near it
``judging``         how bodies are asked about, and the laws that each answer must keep
``peers``           adapters that ask other libraries the same question
``hard_cases``      the catalogue of pairs on which solvers fail, and its judge
``tolerances``      every epsilon of the above
==================  ============================================================================

It imports public names, and bodies, surfaces and answers of ``cross_check``. ``bench`` imports it
as ``truth``, for ``./run`` adds ``test`` to the import path. Tests of a file stand beside it.
"""
