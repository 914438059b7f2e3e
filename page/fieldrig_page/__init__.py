"""The page of a rig in a browser: its picture, fronts, values, traffic, scope and faults."""
