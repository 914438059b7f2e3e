"""Modbus: requests and responses, and the lines that carry them."""
