"""An unchanged master in the virtual time of a rig: its threads run by turns, and its waits take no real time."""
