"""The operator terminal TR4/TR5: the device, and the card's side of it.

Source: manual 4.5 and 5.12; digest chapters 8.1 and 16.  The manual only says that it conforms to CANopen; its objects
are ours, and docs/arp-terminal.md has them.
"""
