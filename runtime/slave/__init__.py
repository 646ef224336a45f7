"""A slave: what it executes by itself, and how it talks to its master (SPEC 2, 5, 6)."""
