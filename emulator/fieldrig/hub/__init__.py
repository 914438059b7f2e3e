"""A bus in real time, with members in several processes."""
