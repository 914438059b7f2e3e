"""Scenarios: what happens to a rig, and what has to hold meanwhile."""
