"""The other ends of the ports: reference masters that a test, a script or a device of a rig runs.

A master is a script: a generator that yields accesses to the memory and pauses, and gets the words that it reads.
`carry_out` runs a script over anything that reads and writes words.
"""
