"""What CiA 402 says in tables: states, commands, modes and error codes of drives, to name them or to compute them."""
