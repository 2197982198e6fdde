"""Outputs of the node: results of cycles, markers, diagnostics, replay files.

Each publishes or writes its part of the live scene when it is due.
"""
