"""Names, types and signatures: what the drawing refers to.

``resolve`` makes the model of a project; ``Scope`` is a POU's view of it.
"""

from ldc.model.resolver import resolve
from ldc.model.scope import Scope

__all__ = ["Scope", "resolve"]
