"""Curves of cams: motion laws and splines, made of pieces in closed form; all devices with cams share them."""
