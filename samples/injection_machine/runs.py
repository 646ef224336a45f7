"""Cycles of the injection machine in virtual time: where it came to rest, how long each phase took.

``machine(...)`` compiles an arrangement once, ``cycles(...)`` runs it from a seed. Arrangements: "slave",
the axes on a slave at 1 ms; "scan", the same ladder and axes on the master alone, called in every scan of
10 ms.
"""

from __future__ import annotations

import importlib.util
import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType

from ldc import pipeline
from ldc.cli.native import native_code
from ldc.cli.starting import start
from ldc.cli.system import placement, together
from ldc.il.coordination import Coordination
from ldc.il.external import Binding
from ldc.il.placement import points
from runtime.field import Field, field_size
from runtime.master.wiring import Wiring
from runtime.slave.algorithm import makers
from runtime.system import System

HERE = Path(__file__).resolve().parent
REGIMES, ARRANGEMENTS = ("machine", "controller-limited"), ("slave", "scan")
TARGETS = {"V/P switch-over": ("screw", "inject", 14.0), "hold end": ("screw", "hold", 5.0),
           "charge end": ("screw", "charge", 71.0), "mould open": ("clamp", "clamp", 350.0)}
"""The four metrics: axis, what moved it, where it should have come to rest (mm)."""
PHASES = {"clamp": 2.0, "inject": 1.0, "charge": 1.0, "cooling": 0.5, "suck-back": 0.5, "open": 2.0,
          "eject": 1.0}
"""In the order of the sequence, with their length in the paper (s)."""
LIMITS = {"velocity": 170.0, "acceleration": 2500.0, "jerk": 50000.0}
"""Of the ejector's S-curve, as `ejector.ld` has them (mm/s and derivatives)."""
_MODULES = ("clamp", "inject", "charge", "cooling", "suck_back", "ejector")
_VALVES = ("clamp", "inject", "charge", "suck_back")


@dataclass(frozen=True, slots=True)
class Result:
    """Of one run, one a cycle: ``errors`` of each metric (mm), lengths of the ``phases`` (s); ``most``: the
    largest velocity, acceleration and jerk of the ejector's S-curve."""

    errors: dict[str, list[float]]
    phases: dict[str, list[float]]
    most: dict[str, float]


@dataclass(slots=True)
class Watched:
    """A plant, and what its ejector's S-curve did: differences over a step of the velocity."""

    step_of: Callable[[int, int], None]
    speed_of: Callable[[], float]
    most: dict[str, float] = field(default_factory=lambda: dict.fromkeys(LIMITS, 0.0))
    speed: float = 0.0
    acceleration: float = 0.0

    def step(self, now_ns: int, dt_ns: int) -> None:
        self.step_of(now_ns, dt_ns)
        speed = self.speed_of()
        if speed or self.speed or self.acceleration:
            acceleration, seconds = (speed - self.speed) / dt_ns * 1e9, dt_ns * 1e-9
            jerk = (acceleration - self.acceleration) / seconds
            for name, value in zip(LIMITS, (speed, acceleration, jerk), strict=True):
                self.most[name] = max(self.most[name], abs(value))
            self.speed, self.acceleration = speed, acceleration


@dataclass(frozen=True, slots=True)
class Compiled:
    """An arrangement, ready to be run. ``wires``: points of the field by what the plant calls them."""

    result: pipeline.Compiled
    bindings: tuple[Binding, ...]
    said: Coordination
    plant: ModuleType
    wires: dict[str, str]


@cache
def machine(arrangement: str, folder: Path = HERE) -> Compiled:
    """Compiles it. Raises Invalid when the project in ``folder`` does not compile."""
    with TemporaryDirectory() as own:
        wires = {}
        if arrangement == "scan":
            shutil.copytree(folder, own, dirs_exist_ok=True)
            folder = Path(own)
            wires = _alone(folder)
        result = pipeline.compile_paths([str(folder)])
        spec = importlib.util.spec_from_file_location("injection_plant", folder / "plant.py")
        plant = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(plant)
        return Compiled(result, native_code(result), together(result), plant, wires)


def _alone(folder: Path) -> dict[str, str]:
    """Takes the slave away: each axis gets its ruler and its valve by terminals of the master."""
    project = folder / "ldc.toml"
    project.write_text(project.read_text().replace('slave1 = "slave"\n', ""))
    wires, declared = {}, []
    for number, name in enumerate((*_VALVES, "ejector")):
        ruler, valve = f"%ID{16 + number}", f"%QD{16 + number}"
        declared.append(f"    {name}_ruler AT {ruler} : REAL;\n    {name}_valve AT {valve} : REAL;\n")
        wires |= {f"{name}.axis.measured": ruler, f"{name}.axis.reference": valve}
        source = folder / f"{name}.ld"
        pins = f"AXIS(\n        measured := {name}_ruler,\n        reference => {name}_valve,\n"
        source.write_text(source.read_text().replace("AXIS(\n", pins))
    terminals = folder / "io.ld"
    terminals.write_text(terminals.read_text().replace("END_VAR", "".join(declared) + "END_VAR"))
    return wires


class _Renamed:
    """A field in which the plant finds its points by other names."""

    def __init__(self, points_: Field, names: dict[str, str]) -> None:
        self.points, self.names = points_, names

    def reader(self, path: str) -> Callable[[], float]:
        return self.points.reader(self.names.get(path, path))

    def readers(self, paths: list[str]) -> Callable[[], tuple[float, ...]]:
        return self.points.readers([self.names.get(path, path) for path in paths])

    def writer(self, path: str) -> Callable[[float], None]:
        return self.points.writer(self.names.get(path, path))


def system(made: Compiled, regime: str, seed: int, engine: str = "vm", watch: bool = True
           ) -> tuple[System, object, Watched | None]:
    """The controller with its plant, switched to automatic; the plant; who watches the S-curve on a slave,
    None when there is no slave or nobody is to ``watch``."""
    parameters = json.loads((HERE / "plant.json").read_text()) | {"regime": regime}
    controller = start(made.result, 10_000_000, made.result.sources.manifest, engine, made.bindings)
    placed = placement(made.result)
    places = points(made.result.program, placed)
    words = Field(bytearray(field_size(places)), places)
    plant = made.plant.Plant(_Renamed(words, made.wires), parameters, seed)
    watched = Watched(plant.step, words.reader("ejector.axis.speed")) if placed and watch else None
    local = {pin.path.upper() for p in placed for pin in p.local}
    whole = System(controller, placed, makers(made.result.program, made.bindings), made.said, words,
                   plant=watched or plant, wiring=Wiring(words, sorted(words.asked - local)))
    for name in ("guard", "motor_ok", "auto_switch"):
        controller.set(name, True)
    for name in _VALVES:
        valve = parameters["regimes"][regime]["inject" if name == "suck_back" else name]
        controller.set(f"{name}.lead", valve["delay_s"] + valve["lag_s"])
    return whole, plant, watched


def cycles(made: Compiled, regime: str, seed: int, count: int, tell: Callable[[int], None] = lambda _: None,
           engine: str = "vm") -> Result:
    """Runs until so many cycles are over; ``tell`` is called with their number after each.
    Raises RuntimeError when a cycle does not end within 20 s."""
    whole, plant, watched = system(made, regime, seed, engine)
    controller = whole.machine
    read = controller.reader(controller.find(f"{name}.start" for name in _MODULES))
    before, starts, limit = (), [], 2000
    while len(starts) <= count * len(PHASES):
        whole.scan()
        limit -= 1
        now = read()
        if now != before:
            if any(n and not b for n, b in zip(now, before or (False,) * len(now))):
                starts.append(whole.now())
                if len(starts) % len(PHASES) == 1:
                    tell(len(starts) // len(PHASES))
                    limit = 2000
            before = now
        if not limit:
            raise RuntimeError(f"cycle {len(starts) // len(PHASES) + 1} does not end: "
                               f"{[str(f.message) for f in controller.faults]}")
    lengths = [(b - a) * 1e-9 for a, b in zip(starts, starts[1:])]
    phases = {name: lengths[n :: len(PHASES)] for n, name in enumerate(PHASES)}
    # The clamp rests twice in a cycle: where it closes it has left the neighbourhood of the target.
    errors = {name: [at - target for _, axis, by, at in plant.journal
                     if (axis, by) == (of, drive) and abs(at - target) < 100][:count]
              for name, (of, drive, target) in TARGETS.items()}
    return Result(errors, phases, dict(watched.most) if watched else {})
