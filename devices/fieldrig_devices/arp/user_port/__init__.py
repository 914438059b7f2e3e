"""The USER serial port of the ARP card: frames, the card's side of it, and a client for PCs."""
