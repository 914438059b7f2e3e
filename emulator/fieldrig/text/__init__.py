"""Text for people: the nearest names, numbers, pictures."""
