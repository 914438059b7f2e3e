"""The limits for outsiders, and the readers of what they send."""
