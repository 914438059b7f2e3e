"""Serial lines: bytes, control lines, baud rates."""
