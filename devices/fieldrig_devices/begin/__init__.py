"""`fieldrig new`: creates a folder with a rig file, the files that it names, and a test."""
