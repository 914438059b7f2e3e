"""The memory that a device keeps when it is switched off."""
