"""Projects in the formats of other tools."""
