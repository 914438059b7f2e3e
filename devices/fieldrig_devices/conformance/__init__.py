"""A conformance suite for any CANopen node, emulated or foreign, on any of our buses (`fieldrig conform`)."""
