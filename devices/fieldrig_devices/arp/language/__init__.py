"""The ARP's BASIC: text is parsed into a checked tree, and the tree is compiled to Python."""
