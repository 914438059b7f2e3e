"""A CANopen slave (CiA 301) made from an EDS or DCF file; each service has a file of its own.

`sdo.client` and `managed_slave` are parts of a master, for devices that have slaves of their own.
"""
