"""A rig in real time, with a process for each device."""
