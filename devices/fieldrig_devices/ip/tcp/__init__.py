"""TCP by RFC 9293, as passive code."""
