"""What is made of IL for an engine other than the VM: C sources, shared objects, firmware (DESIGN section 5).

Empty until native code arrives; the VM runs the image that ``ldc.il.image`` makes.
"""
