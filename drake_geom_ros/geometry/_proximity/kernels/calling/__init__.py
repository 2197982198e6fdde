"""How kernels are called: signatures, addresses, rows of results; pairs of extreme sizes."""
