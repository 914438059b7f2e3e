"""The Socapel PAM axes manager, release 2.5 (manual 006.8007.B)."""
