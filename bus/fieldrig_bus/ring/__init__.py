"""Rings of stations: what they have in common (`topology`, `breaks`, `transport`), and SERCOS (`sercos`)."""
