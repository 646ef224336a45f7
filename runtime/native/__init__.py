"""The engine ``native``: runs the shared object that ``ldc.backends.c`` made, on memory of its own."""
