"""Shared parts of the run times of the emulated languages."""
