"""What the run times of the emulated languages share."""
