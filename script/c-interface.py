"""Writes runtime/c_interface.py: what Python and native code call of each other, parsed. With it neither
needs a parser of C when they start, which took longer than all of a short run.

    python script/c-interface.py > runtime/c_interface.py
"""

from __future__ import annotations

import contextlib
import io
import re
import tempfile
from pathlib import Path

import cffi

INTERFACE = """
uint32_t ldc_abi(void);
uint32_t ldc_size(void);
int32_t ldc_run(uint8_t *memory, uint32_t program);
int32_t ldc_bind(uint32_t number, void (*entry)(const void *, void *, void *, uint32_t), uint8_t **memory);
uint32_t ldc_frame(void);
int32_t ldc_step(uint8_t *memory, uint32_t program, uint8_t *pace);
extern uint8_t *ldc_memory;
void ldc_entry(const void *in, void *out, void *state, uint32_t dt_us);
void ldc_guard(int64_t *where);
"""

HEAD = '''"""The interface of native code, parsed: ``script/c-interface.py`` has it as text, and wrote this."""

'''


def text() -> str:
    """The module."""
    ffi = cffi.FFI()
    ffi.cdef(INTERFACE)
    ffi.set_source("runtime.c_interface", None)
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, "made.py")
        with contextlib.redirect_stdout(io.StringIO()):  # it tells what it does
            ffi.emit_python_code(str(made))
        found = made.read_text(encoding="utf-8").partition("\n")[2]
    found = re.sub(r"_types = (b'.*'),\n", lambda m: f"_types = (\n{_wrapped(m[1])}    ),\n", found)
    return HEAD + re.sub(r",\(?b'", lambda m: f",\n        {m[0][1:]}", found)


def _wrapped(literal: str) -> str:
    parts = re.findall(r"(?:\\x..|.){1,24}", literal[2:-1])
    return "".join(f"        b'{part}'\n" for part in parts)


if __name__ == "__main__":
    print(text(), end="")
