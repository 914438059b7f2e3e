"""The card on CAN: master of its I/O modules, a node for other masters, and data exchange between cards."""
