"""The ring of a PAM: what the PAM and its ST1 and Smart-IO nodes tell each other (sections 3.1 to 3.5)."""
