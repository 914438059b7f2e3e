"""Pulse outputs and pulse inputs, for every device that has some."""
