"""A rig in one process, in virtual time."""
