"""Master and slaves: the states they are in (SPEC 5)."""
