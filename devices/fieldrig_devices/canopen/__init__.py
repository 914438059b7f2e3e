"""A CANopen slave (CiA 301) made from an EDS or DCF file: one file, one service.

`sdo_client` and `remote_node` are the parts of a master, for devices that have slaves of their own.
"""
