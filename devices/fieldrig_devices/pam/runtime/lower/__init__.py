"""Lowers a checked application to routines, formulas and tables (`lowered`)."""

from fieldrig_devices.pam.runtime.lower.programs import lower

__all__ = ["lower"]
