"""A rig file: read, checked, and made into devices and buses."""
