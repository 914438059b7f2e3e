"""The messages of a rig, as they are and in files."""
