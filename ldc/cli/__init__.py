"""The command line: one module a command, what they share in `console`, `output` and `compiling`."""
