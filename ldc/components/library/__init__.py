"""Components that come with ldc: descriptors and bodies, found like those of any installed package."""
