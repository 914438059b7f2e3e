"""The Smart-IO node of a PAM's ring: inputs, outputs, keys, LEDs, a display and DC motors."""
