"""Execution of a compiled ARP program: tasks, events, timers, and the interface to the card."""
