"""The function blocks of the library HMISCU_PTOPWM (SCU-097)."""
