"""Running a compiled ARP program: tasks, events, timers, and what it asks of the card."""
