"""The card's analog inputs and outputs, its cam switches and its tension regulators (digest 6.1, 9, 14, 15)."""
