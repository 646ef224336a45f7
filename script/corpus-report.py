"""Which files of a folder compile, and the codes that stop the others: `script/corpus-report FOLDER`."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from ldc.diagnostics import Severity
from ldc.pipeline import compile_paths


def main(arguments: list[str]) -> int:
    if len(arguments) != 1 or not Path(arguments[0]).is_dir():
        print("usage: script/corpus-report FOLDER", file=sys.stderr)
        return 2
    folder, total, good, rungs = Path(arguments[0]), 0, 0, 0
    files_with: Counter[str] = Counter()
    for path in sorted(folder.rglob("*.xml")):
        result = compile_paths([str(path)])
        errors = Counter(d.code for d in result.diagnostics if d.severity is Severity.ERROR)
        built = sum(map(len, result.units.values()))
        total, good, rungs = total + 1, good + (result.program is not None), rungs + built
        files_with.update(errors.keys())
        why = " ".join(f"{code}:{count}" for code, count in sorted(errors.items()))
        print(f"{'ok ' if result.program is not None else '-- '} {built:4} rungs  {path.relative_to(folder)}  {why}")
    print(f"\n{good} of {total} files compile; {rungs} rungs built")
    for code, count in files_with.most_common():
        print(f"  {code} in {count} files")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
