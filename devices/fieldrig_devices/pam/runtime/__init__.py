"""The run time of an application: its programs, cycle by cycle."""
