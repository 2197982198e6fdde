"""What measures and judges our answers; loaded by those who ask for it, and by nobody else.

========================================  ======================================================
``bodies`` ``random_bodies`` ``grids``    what is asked about: shapes at poses, by public names
``arms``
``truth``                                 two independent ones: 50 digits, and a search over
                                          directions; and that of meshes, by all triangles
``surfaces`` ``laws``                     what bodies are, and what an answer must hold
``asking`` ``lost_process`` ``peers``     who is asked: we, and others in processes of their own
``hunt``                                  pairs that evolve towards an answer that breaks a law
``hard_cases``                            the catalogue of what solvers fail on, and its judge
``accuracy``                              errors over times, ours and those of peers
``pages`` ``tolerances``                  what all of them share
========================================  ======================================================

It imports public names only. ``bench`` and ``test`` use it, and of the command line ``accuracy``.
"""
