"""The card on CAN: master of its I/O modules, a node to others, and what cards tell each other."""
