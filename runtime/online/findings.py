"""Why an online change is refused: each code of the runtime's side in one place (DESIGN section 7)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ldc.diagnostics import Diagnostic, Diagnostics, Invalid


def _one(code: str, message: str, help: str) -> Diagnostic:
    found = Diagnostics()
    found.error(code, message, help=help)
    return next(iter(found))


def refused(*found: Diagnostic) -> Invalid:
    """What is raised when a request cannot be done."""
    return Invalid(found)


def type_changed(path: str, old: object, new: object) -> Diagnostic:
    return Diagnostic("LD0820", f"`{path}` is {old} in the running program and {new} in the new one",
                      about=path,
                      help="a value cannot change its type while the program runs: give the variable of the "
                      "new type another name, or stop the program and start the new one")


def task_changed(name: str, what: str) -> Diagnostic:
    return Diagnostic("LD0821", f"task `{name}` {what}", about=name,
                      help="tasks stay as they are while they run; a further task may be added under another "
                      "name, with a multiple of the period of the scans")


def area_full(area: str, needed: int, available: int) -> Diagnostic:
    what = f"area %{area}" if area != "D" else "data area"
    return _one("LD0822", f"the new program needs {needed} bytes of the {what}, the runtime has {available}",
                "use addresses that the runtime has, or start the program again with more memory")


def stale(base: str, running: str) -> Diagnostic:
    return _one("LD0823",
                f"the change was made for program {base[:12] or 'none'}, but {running[:12]} is running",
                "`ldc pull` gives the sources that run now; put the change into them and stage it again")


def out_of_turn(action: str, state: str, help: str) -> Diagnostic:
    return _one("LD0824", f"cannot {action}: {state}", help)


def nothing_staged(action: str) -> Diagnostic:
    return out_of_turn(action, "nothing is staged", "stage a program with `ldc online stage`")


def other_algorithms(paths: Sequence[str]) -> Diagnostic:
    """``paths``: of instances, at least one."""
    named = ", ".join(f"`{path}`" for path in paths[:3]) + (" and more" if len(paths) > 3 else "")
    return _one("LD0862", f"the change brings, drops or alters algorithms of slaves: {named}",
                "with --realtime slaves are processes that execute the program they began with: change the "
                "rest of the program, or end the run and start the new one")


def no_slave(path: str, slave: int) -> Diagnostic:
    return Diagnostic("LD0864", f"slave{slave} is to execute `{path}`, and the runtime has no such slave",
                      about=path,
                      help="slaves are those of [processors] when the runtime was started: let another one "
                      "execute it, or end the run and start the new program")


def in_other_hands(what: str) -> Diagnostic:
    return _one("LD0825", what,
                "`ldc online status` tells whose it is; `ldc online cancel --force` takes it away")


def unusable(what: str, help: str = "stage it with an ldc of the same version as the one that runs, and for "
             "the same engine") -> Diagnostic:
    return _one("LD0826", f"the new program cannot be loaded: {what}", help)


def no_room(folder: Path, error: OSError) -> Diagnostic:
    """Its code cannot be put where it is loaded from."""
    return unusable(f"{error.strerror or error}", f"the runtime puts its code into `{folder}`, beside its socket: "
                    "make room there, or name another with --socket")


def bad_message(what: str) -> Diagnostic:
    return _one("LD0827", f"this is no message of online change: {what}",
                "both ends must be ldc, of versions that know each other: compare `ldc --version`")
