"""Online change: another program takes over between two scans and goes on with the state (DESIGN section 7)."""
