"""Epsilons of images, with unit and reason."""

# Margin [pixels] around the projection of a body's box: more than rounding moves a projection
# within an image of 2^20 pixels, where it is a few times 2^20 EPS.
PIXEL_SLACK = 1e-6

# Limits of sizes and distances [m] in images: the fourth powers of larger and smaller ones exceed
# the range of float64.
SMALLEST_SIZE = 1e-60
LARGEST_SIZE = 1e60

# Cosine of the angle between the normals of neighbouring pixels below which an edge is drawn
# between them: 41 degrees, less than those of a prism of eight sides, more than those of a ball
# of ten pixels.
EDGE_COSINE = 0.75
