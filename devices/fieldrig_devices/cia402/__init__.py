"""CiA 402 (IEC 61800-7-201): power drive systems on an object dictionary."""
