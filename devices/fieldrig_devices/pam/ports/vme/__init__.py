"""The VME DualPort: a mailbox of two FIFOs and a command port (chapter 13)."""
