"""Robots among people, simulated with what stops them, and judged by who knows the truth."""
