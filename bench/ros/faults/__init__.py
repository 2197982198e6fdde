"""Faults that production brings: of clients, of what comes in, and of what the machine allows.

Each fault is a function ``fault(site)``: it does harm, and returns what was not as it should be
after it, an empty text where all was. It takes what is random from ``site.random``.
"""
