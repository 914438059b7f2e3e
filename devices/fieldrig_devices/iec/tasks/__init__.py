"""The tasks of a controller that runs IEC programs: one processor, shared by priority in virtual time."""
