"""The check of user names and passwords."""
