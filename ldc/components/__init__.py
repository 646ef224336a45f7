"""Multi-language components: descriptors, address remap, bodies in C, C++, ST and IL (DESIGN section 6)."""
