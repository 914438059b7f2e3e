"""The operator terminal TR4/TR5: the device, and the card's side of it.

Source: manual 4.5 and 5.12; digest chapters 8.1 and 16.  The manual only says that the terminal conforms to CANopen;
its objects are ours and are described in docs/devices/arp/arp-terminal.md.
"""
