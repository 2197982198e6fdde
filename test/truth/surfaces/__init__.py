"""Contact surfaces: forces and areas in closed form, and the surfaces of nearby poses."""
