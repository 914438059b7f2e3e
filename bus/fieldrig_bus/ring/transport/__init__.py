"""What the rings in real time have in common: how cycles and answers get from process to process."""
