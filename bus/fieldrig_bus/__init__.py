"""Messages and what carries them: CAN, Modbus, serial lines, wires."""
