"""The standard library of IEC 61131-3: functions, conversions, and the standard function blocks as source text."""
