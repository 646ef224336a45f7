"""Processors in real time, each in a process of its own over memory that all share (docs/realtime.md)."""
