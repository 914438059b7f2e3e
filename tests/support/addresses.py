"""Addresses that tests may listen on."""

from fieldrig.testing import free_port

__all__ = ["free_port"]
