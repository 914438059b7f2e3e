"""A TCP/IP stack without sockets, for devices that are reached over a serial line."""
