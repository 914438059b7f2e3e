"""A conformance suite for any CANopen node on any of our buses, ours or a foreign one (`fieldrig conform`)."""
