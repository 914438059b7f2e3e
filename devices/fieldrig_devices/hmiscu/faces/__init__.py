"""The faces of the controller: Modbus and CANopen."""
