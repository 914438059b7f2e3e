"""The ARP's BASIC: from text to a checked tree, and from there to Python."""
