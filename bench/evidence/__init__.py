"""What measures and judges our answers; loaded by those who ask for it, and by nobody else.

========================================  ======================================================
``random_bodies`` ``grids`` ``arms``      what is asked about: shapes at poses, by public names
``truth``                                 two independent ones: 50 digits, and a search over
                                          directions; and that of meshes, by all triangles
``laws``                                  what an answer must hold
``asking`` ``peers``                      who is asked: we, and others in processes of their own
``hard_cases``                            the catalogue of what solvers fail on, and its judge
``accuracy``                              errors over times, ours and those of peers
``pages`` ``tolerances``                  what all of them share
========================================  ======================================================

It imports public names, and of ``cross_check`` what bodies, surfaces and FCL's answers are.
"""
