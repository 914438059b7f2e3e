"""The card's analog inputs and outputs, its digital cams and its tension regulators (digest 6.1, 9, 14, 15)."""
