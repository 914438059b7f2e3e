"""TCP connections as a service sees them, whether they come over Ethernet or a telephone line."""
