"""Logs by name, without a rig: each dialogue as one row, with nodes, objects, registers and values."""
