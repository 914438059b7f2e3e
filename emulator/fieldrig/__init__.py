"""fieldrig: the kernel.  It knows no bus and no device; it finds both by their `kind`."""
