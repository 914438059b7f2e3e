"""The client of `fieldrig dial`, which calls a controller by modem, PPP and the stack of `ip`."""
