"""The front panel of a PAM: its display with message codes, its LED, and the lines of the debugger (chapter 11)."""
