"""The epsilons of images: value, unit and reason."""

# How far [pixels] beyond the projection of a body's box its pixels are looked for: more than
# rounding moves a projection within an image of 2^20 pixels, where it is 2^20 EPS times a few.
PIXEL_SLACK = 1e-6

# Sizes and distances [m] that images are made of: of larger and smaller ones the fourth powers
# leave float64.
SMALLEST_SIZE = 1e-60
LARGEST_SIZE = 1e60

# Cosine of the angle between the normals of neighbouring pixels below which an edge is drawn
# between them: 41 degrees, less than those of a prism of eight sides, more than those of a ball
# of ten pixels.
EDGE_COSINE = 0.75
