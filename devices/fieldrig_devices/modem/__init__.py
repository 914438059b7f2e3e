"""A telephone modem with the Hayes command set."""
