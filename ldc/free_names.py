"""A name beside others that are taken: numbers make it one of its own."""

from __future__ import annotations

from collections.abc import Container


def free_name(wanted: str, taken: Container[str], first: int = 2) -> str:
    """The name that is wanted, or with the least number from ``first`` on that makes it free. ``taken``:
    names in capitals."""
    name, number = wanted, first
    while name.upper() in taken:
        name = f"{wanted}_{number}"
        number += 1
    return name


def claimed(wanted: str, taken: set[str], first: int = 2) -> str:
    """The same; from now on it is taken."""
    name = free_name(wanted, taken, first)
    taken.add(name.upper())
    return name
