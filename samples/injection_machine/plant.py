"""The injection machine as its controller sees it: rulers, valves, clamping force (SPEC 12.1).

An axis follows the velocity reference behind a valve: dv/dt = (g * reference(t - delay) - v) / lag, dx/dt =
v. The gain g is drawn for each motion (the temperature of the oil), the delay for each start and each stop
(the valve). The solution is exact between two changes of the delayed reference. A ruler shows x with noise,
in steps. In the hold phase the screw creeps towards where the packed melt stops it. Lengths in mm, times in
s (``step``: ns), velocities in mm/s, pressures in bar, forces in kN.

``journal`` tells the truth that no ruler shows: (time in ns, axis, what moved it, position where it came to
rest).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from math import cos, exp, log, sin, sqrt, tau
from random import Random

AT_REST = 0.1  # mm/s; what is left of the way is less than 1 um


def normals(random: Random) -> Iterator[float]:
    """Numbers of the standard normal distribution, by Box and Muller: those of ``random.gauss``, which costs
    twice as much a number, and a ruler takes one a step."""
    uniform = random.random
    while True:
        angle, radius = uniform() * tau, sqrt(-2.0 * log(1.0 - uniform()))
        yield cos(angle) * radius
        yield sin(angle) * radius


class Noise:
    """Random numbers of one machine, in one order. ``draw`` gives the next of ``normals``."""

    def __init__(self, seed: int) -> None:
        self.draw = normals(Random(seed)).__next__

    def gauss(self, mean: float, sd: float) -> float:
        return mean + self.draw() * sd


class Drive:
    """What moves an axis: a valve or a servo drive, with its lag, its delay and their spread."""

    def __init__(self, name: str, settings: dict, gain_sd: float) -> None:
        self.name, self.gain_sd = name, settings.get("gain_sd", gain_sd)
        self.lag = settings["lag_s"]
        self.delay_ns, self.delay_sd_ns = settings["delay_s"] * 1e9, settings["delay_sd_s"] * 1e9
        self.reference = 0.0
        self.lasts(0)

    def lasts(self, ns: float) -> None:
        """What remains after so long of a difference in velocity, and what is gone; most steps last as long
        as the one before."""
        self.ns, self.seconds = ns, ns * 1e-9
        self.decay = exp(-self.seconds / self.lag)
        self.gone = 1.0 - self.decay


class Axis:
    """One mass on one ruler; one of its drives moves it at a time."""

    def __init__(self, name: str, position: float, sensor: dict, random: Noise, journal: list) -> None:
        self.name, self.position, self.velocity, self.still = name, position, 0.0, True
        self.drive: Drive | None = None
        self.show: list[Callable[[float], None]] = []
        self.noise, self.grain = sensor["noise_mm"], sensor["step_mm"]
        self.random, self.draw, self.journal = random, random.draw, journal
        self.reached, self.gain, self.delay_ns = 0.0, 1.0, 0.0
        self.coming: deque[tuple[float, float]] = deque()  # (when it reaches the axis, velocity), by time

    def measure(self) -> None:
        """The ruler: noise first, then its steps."""
        grain = self.grain
        shown = round((self.position + self.draw() * self.noise) / grain) * grain
        for show in self.show:
            show(shown)

    def rest(self, now_ns: int) -> None:
        self.journal.append((now_ns, self.name, self.drive.name, self.position))

    def command(self, drive: Drive, reference: float, now_ns: int) -> None:
        """A drive has another reference since ``now_ns``; a start and a stop are commands of their own."""
        if drive.reference == 0.0:
            if not self.still and drive is not self.drive:
                self.rest(now_ns)  # one drive takes over from another
            self.drive, self.gain = drive, self.random.gauss(1.0, drive.gain_sd)
        if drive.reference == 0.0 or reference == 0.0:
            self.delay_ns = max(0.0, self.random.gauss(drive.delay_ns, drive.delay_sd_ns))
        drive.reference = reference
        at = now_ns + self.delay_ns
        if self.coming:
            at = max(at, self.coming[-1][0])
        self.coming.append((at, reference * self.gain))
        self.still = False

    def glide(self, ns: float) -> None:
        """Moves with the velocity that has reached the axis."""
        drive, reached = self.drive, self.reached
        if ns != drive.ns:
            drive.lasts(ns)
        excess = self.velocity - reached
        self.position += reached * drive.seconds + excess * drive.lag * drive.gone
        self.velocity = reached + excess * drive.decay

    def step(self, since_ns: int, now_ns: int) -> bool:
        """Moves on; whether it goes on moving."""
        coming = self.coming
        while coming and coming[0][0] < now_ns:
            when, velocity = coming.popleft()
            if when > since_ns:
                self.glide(when - since_ns)
                since_ns = when
            self.reached = velocity
        self.glide(now_ns - since_ns)
        if self.reached == 0.0 and not coming and abs(self.velocity) < AT_REST:
            self.velocity, self.still = 0.0, True
            self.rest(now_ns)
        self.measure()
        return not self.still


class Hold:
    """The hold phase: the screw packs the melt while there is pressure and no drive moves it."""

    def __init__(self, screw: Axis, settings: dict, random: Noise) -> None:
        self.screw, self.settings, self.random = screw, settings, random
        self.packed, self.lag, self.pressure = 0.0, 0.0, 0.0
        self.holds = False

    def begin(self) -> None:
        """Draws this shot: how far it can be packed, and how fast."""
        s, gauss = self.settings, self.random.gauss
        way = s["mm_per_bar"] * self.pressure * gauss(1.0, s["pressure_sd"])
        self.packed = s["full_at_mm"] - way + gauss(0.0, s["shot_sd_mm"])
        self.lag = s["lag_s"] * gauss(1.0, s["lag_sd"])
        self.holds = True

    def step(self, since_ns: int, now_ns: int) -> bool:
        """Packs while there is pressure; whether there is."""
        if self.pressure > 0.0 and self.screw.still:
            if not self.holds:
                self.begin()
            seconds = (now_ns - since_ns) * 1e-9
            self.screw.position += (self.packed - self.screw.position) * (1.0 - exp(-seconds / self.lag))
            self.screw.measure()
        elif self.holds and self.pressure == 0.0:
            self.holds = False
            self.screw.journal.append((now_ns, "screw", "hold", self.screw.position))
        return self.pressure != 0.0


class Wired:
    """Drives that were wired at once, each with its axis. ``read`` gives their references, ``seen``: what it
    gave in the step before."""

    def __init__(self, drives: list[tuple[Drive, Axis]], read: Callable[[], tuple]) -> None:
        self.drives, self.read, self.seen = drives, read, ()


class Plant:
    """Clamp, screw and ejector. The screw has three drives: injection, charge (metering) and suck-back.

    ``doing``: what goes on, in its order: axes that move, packing, the clamping force. What rests costs
    nothing.
    """

    def __init__(self, field, parameters: dict, seed: int) -> None:
        regime, start = parameters["regimes"][parameters["regime"]], parameters["start"]
        ejector, force = parameters["ejector"], parameters["force"]
        self.random, self.journal = Noise(seed), []

        def axis(name: str, sensor: dict) -> Axis:
            return Axis(name, start[f"{name}_mm"], sensor, self.random, self.journal)

        clamp, screw = axis("clamp", regime["sensor"]), axis("screw", regime["sensor"])
        self.ejector = axis("ejector", ejector["sensor"])
        self.axes = clamp, screw, self.ejector
        self.wired: list[Wired] = []  # the first with the valves of the master
        self.locks, self.full = False, 0.0
        self.unwired = [(clamp, "clamp", regime["clamp"]), (screw, "inject", regime["inject"]),
                        (screw, "charge", regime["charge"]), (screw, "suck_back", regime["inject"]),
                        (self.ejector, "ejector", ejector)]
        self.gain_sd = regime["gain_sd"]
        self.hold, self.show_force = Hold(screw, parameters["hold"], self.random), field.writer("%ID4")
        self.show_eye, self.eye_at, self.eye = field.writer("%IX1.0"), ejector["eye_mm"], False
        self.force, self.full_force, self.force_lag = 0.0, force["full_kn"], force["lag_s"]
        self.doing: list[Callable[[int, int], bool]] = []
        self.connect(field)

    def connect(self, field) -> None:
        """Wires the axes of the modules that are in the program; again when an online change brings more."""
        missing, found, references = [], [], []
        for axis, module, settings in self.unwired:
            try:
                field.reader(f"{module}.axis.reference")
                axis.show.append(field.writer(f"{module}.axis.measured"))
            except LookupError:
                missing.append((axis, module, settings))
                continue
            found.append((Drive(module, settings, self.gain_sd), axis))
            references.append(f"{module}.axis.reference")
        for axis in {axis.name: axis for _, axis in found}.values():
            axis.measure()
        valves = [] if self.wired else ["%QX0.1", "%QD4"]
        if found or valves:
            self.wired.append(Wired(found, field.readers([*references, *valves])))
        self.unwired = missing

    def notice(self, wired: Wired, values: tuple, since_ns: int) -> None:
        """Something of what the controller gives has changed."""
        begins, wired.seen = False, values
        for (drive, axis), reference in zip(wired.drives, values):
            if reference != drive.reference:
                begins = begins or axis.still
                axis.command(drive, reference, since_ns)
        if wired is self.wired[0] and (self.locks, self.hold.pressure) != values[-2:]:
            self.locks, self.hold.pressure = values[-2:]
            self.full, begins = self.full_force if self.locks else 0.0, True
        if begins:
            self.arrange()

    def arrange(self) -> None:
        """Something begins or has come to rest."""
        self.doing = [axis.step for axis in self.axes if not axis.still]
        if not self.ejector.still:
            self.doing.append(self.look)
        if self.hold.pressure or self.hold.holds:
            self.doing.append(self.hold.step)
        if self.full != self.force:
            self.doing.append(self.press)

    def look(self, since_ns: int, now_ns: int) -> bool:
        """The eye that a part falls through, while the ejector moves."""
        if self.eye is not (self.ejector.position > self.eye_at):
            self.eye = not self.eye
            self.show_eye(self.eye)
        return True

    def press(self, since_ns: int, now_ns: int) -> bool:
        """The clamping force follows its valve; whether it has still to."""
        missing = self.full - self.force
        share = 1.0 - exp(-(now_ns - since_ns) * 1e-9 / self.force_lag)
        self.force += missing * share if abs(missing) > 0.1 else missing
        self.show_force(self.force)
        return self.force != self.full

    def step(self, now_ns: int, dt_ns: int) -> None:
        """From ``now_ns - dt_ns`` to ``now_ns``; references were given at its beginning."""
        since_ns = now_ns - dt_ns
        for wired in self.wired:
            values = wired.read()
            if values != wired.seen:
                self.notice(wired, values, since_ns)
        for go_on in self.doing:
            if not go_on(since_ns, now_ns):
                self.arrange()
