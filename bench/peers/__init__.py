"""The project beside pydrake, MuJoCo, python-fcl and Coal, on the same scenes in one run."""
