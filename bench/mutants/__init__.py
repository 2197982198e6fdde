"""Mutants: the code with one fault put in, to see whether the tests notice."""
