"""IL to C, and C to a shared object by gcc (DESIGN section 5, docs/native.md).

    emit.py      a program into a BuildPlan: the C files, each with a digest
    gcc.py       a BuildPlan into an Artifact: chunks that changed are compiled, then all are linked
"""
