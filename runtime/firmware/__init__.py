"""The engine ``firmware``: what a microcontroller did in a run, as a machine that goes through it again."""
