"""Online change: another program goes on with the state, between two scans (DESIGN section 7)."""
