"""The ring of a PAM: frames between the axes manager and its nodes."""
