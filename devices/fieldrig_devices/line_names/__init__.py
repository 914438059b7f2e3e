"""Bytes of serial lines and telephone calls by name: whatever protocol they carry, else as readable text."""
