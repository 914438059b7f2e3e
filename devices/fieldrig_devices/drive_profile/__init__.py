"""The tables of CiA 402: states, commands, modes and error codes of drives, to name them or to compute them."""
