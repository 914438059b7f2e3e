"""The part that is alike in all controllers that run IEC programs: downloads, online changes, debugging, points."""
