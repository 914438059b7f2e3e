"""Faults of buses and devices that are injected on purpose."""
