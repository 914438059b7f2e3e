"""A CANopen slave (CiA 301) made from an EDS or DCF file: one file, one service."""
