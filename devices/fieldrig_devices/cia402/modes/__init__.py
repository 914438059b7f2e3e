"""Modes of operation, each in a file of its own."""
