"""The objects of an application: hardware behind the ring, and pipes (chapters 2, 3 and 5 of the manual)."""
