"""The names of elementary types, which that editor writes in small letters, in capitals."""

from __future__ import annotations

from ldc.parser import ast
from ldc.records import replace
from ldc.types import ELEMENTARY


def plain_pou(pou: ast.Pou) -> ast.Pou:
    return replace(pou, var_blocks=tuple(map(plain_section, pou.var_blocks)),
                   result=_plain(pou.result) if pou.result is not None else None)


def plain_section(section: ast.VarBlock) -> ast.VarBlock:
    return replace(section, variables=tuple(replace(v, type=_plain(v.type)) for v in section.variables))


def plain_type(declared: ast.TypeDecl) -> ast.TypeDecl:
    return replace(declared, type=_plain(declared.type))


def _plain(type_: ast.TypeExpr) -> ast.TypeExpr:
    if isinstance(type_, ast.NamedType) and type_.name.upper() in ELEMENTARY:
        return replace(type_, name=type_.name.upper())
    if isinstance(type_, ast.ArrayType):
        return replace(type_, element=_plain(type_.element))
    if isinstance(type_, ast.StructType):
        return replace(type_, fields=tuple(replace(f, type=_plain(f.type)) for f in type_.fields))
    return type_
