"""The virtual machine: IL compiled to Python functions, and a stepping interpreter on the same memory."""
