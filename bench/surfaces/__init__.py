"""Benchmarks and searches of contact surfaces."""
