"""The signals of wires: values, motions, pulse trains and pulse-width modulation, with their encoding."""
