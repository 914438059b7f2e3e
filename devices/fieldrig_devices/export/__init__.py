"""What a rig is made of, in the files of other tools: CAN networks as DBC, register tables as CSV and Markdown."""
