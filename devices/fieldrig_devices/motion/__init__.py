"""How axes get from one place or speed to another, for whatever moves them."""
