"""Byte streams between devices with a TCP/IP stack of their own and the listeners of this host."""
