"""P, the transfer of data between the master and a slave over shared memory (SPEC 2, docs/protocol.md)."""
