"""The questions of tools to a rig, and their answers."""
