"""The ways to the memory from outside: Modbus registers, words over TCP, and an S7 data block."""
