"""The search for faults that break a program: a scenario, and what may happen besides."""
