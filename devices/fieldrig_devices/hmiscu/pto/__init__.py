"""PTO: the pulse train of channel 0, its profiles, its states and its errors."""
