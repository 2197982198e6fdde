"""Service handlers of the node, and the table that lists them.

The message of a failed call states the request, the reason and the allowed values.
"""
