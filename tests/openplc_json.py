"""Drawings of OpenPLC Editor 4 in JSON, written by functions: a node is a dict, an edge `("a", "b")` or, with
the names of its ends, `("a.Q", "b.IN")`."""

from __future__ import annotations

import json


def node(kind: str, id_: str, x: int = 0, y: int = 0, **data) -> dict:
    return {"id": id_, "type": kind, "position": {"x": x, "y": y}, "measured": {"width": 24, "height": 24},
            "data": {"numericId": id_, "executionOrder": 0, **data}}


def left() -> dict:
    return node("powerRail", "left", variant="left")


def right() -> dict:
    return node("powerRail", "right", 900, variant="right")


def contact(id_: str, name: str, variant: str = "default", x: int = 50, y: int = 0) -> dict:
    return node("contact", id_, x, y, variant=variant, variable={"name": name})


def coil(id_: str, name: str, variant: str = "default", x: int = 500, y: int = 0) -> dict:
    return node("coil", id_, x, y, variant=variant, variable={"name": name})


def opening(id_: str, x: int = 20, y: int = 0) -> dict:
    return node("parallel", id_, x, y, type="open")


def closing(id_: str, x: int = 400, y: int = 0) -> dict:
    return node("parallel", id_, x, y, type="close")


def block(id_: str, type_: str, inputs: str, outputs: str, instance: str = "", x: int = 200, y: int = 0,
          enable: bool = False, variables: dict | None = None, **data) -> dict:
    """``inputs`` and ``outputs``: pins as `IN:bool PT:time`; ``variables``: what stands at pins, by pin."""
    pins = [(side, *pin.split(":")) for side, text in (("input", inputs), ("output", outputs))
            for pin in text.split()]
    sides = {side: [{"id": name} for kind, name, _ in pins if kind == side] for side in ("input", "output")}
    declared = [{"name": name, "class": side, "type": {"definition": "base-type", "value": of}}
                for side, name, of in pins]
    variant = {"name": type_, "type": "function-block" if instance else "function", "variables": declared}
    kinds = {name: side for side, name, _ in pins}
    connected = [{"handleId": pin, "type": kinds[pin], "variable": {"name": text}}
                 for pin, text in (variables or {}).items()]
    return node("block", id_, x, y, variant=variant, variable={"name": instance}, executionControl=enable,
                inputHandles=sides["input"], outputHandles=sides["output"],
                inputConnector=sides["input"][0] if sides["input"] else None,
                outputConnector=sides["output"][0] if sides["output"] else None,
                connectedVariables=connected, **data)


def variable(id_: str, kind: str, name: str, x: int = 0, y: int = 0, **data) -> dict:
    """Of FBD: ``kind`` is input, output or inout."""
    return node(f"{kind}-variable", id_, x, y, variable={"name": name}, **data)


def edges(*wires: tuple[str, str]) -> list[dict]:
    found = []
    for number, (source, target) in enumerate(wires):
        (a, _, out), (b, _, into) = source.partition("."), target.partition(".")
        found.append({"id": f"e{number}", "source": a, "sourceHandle": out or "output", "target": b,
                      "targetHandle": into or "input"})
    return found


def rung(nodes: list[dict], *wires: tuple[str, str], comment: str = "") -> dict:
    return {"id": "r", "comment": comment, "nodes": [left(), *nodes, right()], "edges": edges(*wires)}


def ladder(*rungs: dict) -> dict:
    return {"name": "p", "rungs": list(rungs)}


def diagram(nodes: list[dict], *wires: tuple[str, str]) -> dict:
    return {"name": "p", "rung": {"comment": "", "nodes": nodes, "edges": edges(*wires)}}


def program(body: dict, variables: str, kind: str = "PROGRAM", name: str = "p") -> str:
    return f"{kind} {name}\nVAR\n{variables}\nEND_VAR\n\n{json.dumps(body, indent=2)}\nEND_{kind}\n"


def entry(name: str, type_: str, **more) -> dict:
    """A variable in JSON."""
    return {"name": name, "type": {"definition": "base-type", "value": type_}, "location": "",
            "documentation": "", "class": "local", **more}


def project(pous=(), types=(), variables=(), tasks=(), instances=()) -> str:
    resource = {"tasks": list(tasks), "instances": list(instances), "globalVariables": list(variables)}
    return json.dumps({"meta": {"name": "x", "type": "plc-project"},
                       "data": {"pous": list(pous), "dataTypes": list(types),
                                "configuration": {"resource": resource}}}, indent=2)


def task(name: str, interval: str = "T#20ms", triggering: str = "Cyclic") -> dict:
    return {"name": name, "triggering": triggering, "interval": interval, "priority": 1}


def pou(kind: str, name: str, language: str, value, variables=(), **more) -> dict:
    body = {"language": language, "value": value}
    return {"type": kind, "data": {"name": name, "language": language, "variables": list(variables),
                                   "body": body, "documentation": "", **more}}
