"""Handlers of services: each reads a request, and fills the response or refuses it."""
