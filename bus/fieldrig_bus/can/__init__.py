"""CAN: frames, the bus model, and what carries them."""
