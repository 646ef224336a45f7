"""When which thread of which processor executes, in virtual time (SPEC 6.1, docs/scheduling.md)."""
