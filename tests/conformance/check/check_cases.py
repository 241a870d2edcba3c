"""All single-defect FMUs, of whatever kind, as one list of cases."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import defects_archive
import defects_dynamic
import defects_static
from check_fixture import BASE_XML, members, swapped, write


class Case(NamedTuple):
    """`build` writes the FMU to a path and returns where it is; `kind` is static, archive or dynamic."""

    kind: str
    rule: str
    what: str
    build: Callable[[Path], Path]

    def __str__(self) -> str:
        return f"{self.rule}: {self.what}"


def _static(defect: defects_static.Defect) -> Case:
    return Case("static", defect.rule, defect.what, lambda file: write(file, members(defect.xml())))


def _dynamic(defect: defects_dynamic.Defect) -> Case:
    xml = swapped(*defect.edits) if defect.edits else BASE_XML
    return Case("dynamic", defect.rule, defect.what, lambda file: write(file, members(xml, defect=defect.macro)))


STATIC = [_static(defect) for defect in defects_static.DEFECTS]
ARCHIVE = [Case("archive", *defect) for defect in defects_archive.DEFECTS]
DYNAMIC = [_dynamic(defect) for defect in defects_dynamic.DEFECTS]
CASES = [*STATIC, *ARCHIVE, *DYNAMIC]
