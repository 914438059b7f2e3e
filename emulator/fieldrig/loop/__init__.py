"""The time and the loop of one process."""
