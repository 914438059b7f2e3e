"""The parts of a rig in files of other tools: CAN networks as DBC, register tables as CSV and Markdown."""
