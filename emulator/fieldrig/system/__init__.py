"""The operating system's side of a process: files, streams, cores, exit codes."""
