"""Plants for the machines: axes, winders and tanks, on wires with units."""
