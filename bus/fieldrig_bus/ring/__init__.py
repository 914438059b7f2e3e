"""Rings of stations: what they have in common, SERCOS (`sercos`), and the ring of a PAM (`pam`)."""
