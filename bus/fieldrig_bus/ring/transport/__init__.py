"""Transport of cycles and answers between processes, for rings of any kind in real time."""
