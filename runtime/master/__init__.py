"""The master's part of a controller: modules, messages, the customised program (SPEC 3, 4, 6)."""
