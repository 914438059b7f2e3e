"""The values of a device that tools read and write."""
