"""XML elements of TC6: the few ways in which they are made."""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element, SubElement

from ldc.parser.plcopen.kept import NAMESPACE as OURS

NAMESPACE, XHTML = "http://www.plcopen.org/xml/tc6_0201", "http://www.w3.org/1999/xhtml"
_STRING = re.compile(r"'(?:[^'$]|\$.)*'|\"(?:[^\"$]|\$.)*\"", re.DOTALL)
_NO_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")


def add(parent: Element, tag: str, text: str = "", **attributes: object) -> Element:
    """A child with attributes in the order given (None: left out); an underscore behind a name is dropped."""
    made = SubElement(parent, tag)
    for name, value in attributes.items():
        if value is not None:
            made.set(name.rstrip("_"), prose(str(value)))
    if text:
        made.text = text
    return made


def prose(text: str) -> str:
    """Words, without characters that no XML can hold."""
    return _NO_XML.sub("\ufffd", text)


def code(text: str) -> str:
    """Text of a language; what no XML can hold stands in strings there, and is written as `$hh`."""
    def coded(match: re.Match) -> str:
        digits = 2 if match[0][0] == "'" else 4
        return _NO_XML.sub(lambda c: f"${ord(c[0]):0{digits}X}", match[0])

    return prose(_STRING.sub(coded, text)) if _NO_XML.search(text) else text


def without_margin(text: str) -> str:
    """The lines of a body without the space that all of them have on their left."""
    lines = [line.rstrip() for line in text.split("\n")]
    while lines and not lines[0].strip():
        lines.pop(0)
    while lines and not lines[-1].strip():
        lines.pop()
    margin = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
    return "\n" + "".join(f"{line[margin:]}\n" for line in lines)


def formatted(parent: Element, tag: str, text: str) -> Element:
    """Text in the one form that TC6 has for it: a paragraph."""
    made = add(parent, tag)
    add(made, "xhtml:p", text)
    return made


def own_data(parent: Element, topic: str) -> Element:
    """A place for data of ours, which other tools are asked to preserve."""
    holder = parent.find("addData")
    if holder is None:
        holder = add(parent, "addData")
    data = add(holder, "data", name=f"{OURS}/{topic}", handleUnknown="preserve")
    return add(data, topic, xmlns=OURS)


def number(value: float) -> str:
    return str(round(value))
