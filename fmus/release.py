"""Writes a release: the native FMUs of both FMI versions, SHA-256 sums, and a bill of materials (SPDX 2.3).

    python -m fmus.release DIR

writes DIR/native/NAME.fmu, DIR/native-fmi3/NAME.fmu, DIR/ahv.spdx.json and DIR/SHA256SUMS. What lies in DIR already,
such as a wheel, stands in the bill and the sums, too. SOURCE_DATE_EPOCH, if it is set, is the time in the bill.
"""
import hashlib
import json
import os
import re
import shutil
import sys
import time
from importlib.metadata import version
from pathlib import Path

from . import native_flavour
from .builder import folder
from .description import COPYRIGHT, LICENSE
from .places import written

SUMS, BILL = "SHA256SUMS", "ahv.spdx.json"

# What is in the FMUs beside our own work, or made them: name, version, licence, relation to ours, what it does there.
OTHERS = (
    ("fmi-standard", "2.0.5", "BSD-2-Clause", "CONTAINED_BY", "header files of FMI 2.0, in sources/"),
    ("fmi-standard", "3.0.2", "BSD-2-Clause", "CONTAINED_BY", "header files of FMI 3.0, in sources/"),
    ("casadi", version("casadi"), "LGPL-3.0-or-later", "BUILD_TOOL_OF", "generates model.c from the model's equations"),
    ("ziglang", native_flavour.versions()["ziglang"], "MIT", "BUILD_TOOL_OF",
     "compiles the libraries, with what it needs of compiler-rt (Apache-2.0 WITH LLVM-exception) inside"),
)


def write(target: Path) -> list[Path]:
    """Write a release into the folder `target` from the FMUs that are built; the files that it has.

    Raises RuntimeError where an FMU of one version is built without that of the other.
    """
    built = {fmi: {path.name: path for path in sorted((written() / folder("native", fmi)).glob("*.fmu"))}
             for fmi in native_flavour.FLAVOUR.versions}
    for fmi, files in built.items():
        if missing := set().union(*built.values()) - set(files):
            raise RuntimeError(f"{', '.join(sorted(missing))} of FMI {fmi} is not built; ahv build writes it.")
        place = target / folder("native", fmi)
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        for name, path in files.items():
            shutil.copyfile(path, place / name)
    for name in (BILL, SUMS):
        (target / name).unlink(missing_ok=True)
    (target / BILL).write_text(json.dumps(bill(target, content(target)), indent=1) + "\n", encoding="utf-8")
    (target / SUMS).write_text("".join(f"{digest(path)}  {path.relative_to(target).as_posix()}\n"
                                       for path in content(target)), encoding="utf-8")
    return [*content(target)]


def content(target: Path) -> list[Path]:
    """All files of a release, in order."""
    return sorted(path for path in target.rglob("*") if path.is_file())


def digest(path: Path, kind: str = "sha256") -> str:
    """The checksum of a file."""
    return hashlib.new(kind, path.read_bytes()).hexdigest()


def identity(*words: str) -> str:
    """An identifier as SPDX wants it."""
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.]+", "-", "-".join(words))


def package(name: str, number: str, licence: str, about: str, by: str = "NOASSERTION") -> dict[str, object]:
    """A package of the bill; `by` is its copyright."""
    return {"SPDXID": identity("Package", name, number), "name": name, "versionInfo": number, "comment": about,
            "downloadLocation": "NOASSERTION", "filesAnalyzed": False, "licenseConcluded": licence,
            "licenseDeclared": licence, "copyrightText": by}


def bill(target: Path, files: list[Path]) -> dict[str, object]:
    """The bill of materials of `files`, below the folder `target`, as SPDX 2.3 has it."""
    ours = package("ahv", version("ahv"), LICENSE, "models, builder and master", COPYRIGHT)
    others = [package(name, number, licence, about) for name, number, licence, _, about in OTHERS]
    listed = [{"SPDXID": identity("File", path.relative_to(target).as_posix()),
               "fileName": f"./{path.relative_to(target).as_posix()}", "licenseConcluded": LICENSE,
               "licenseInfoInFiles": ["NOASSERTION"], "copyrightText": COPYRIGHT,
               "checksums": [{"algorithm": kind.upper(), "checksumValue": digest(path, kind)}
                             for kind in ("sha1", "sha256")]} for path in files]
    related = [("SPDXRef-DOCUMENT", "DESCRIBES", ours["SPDXID"]),
               *((file["SPDXID"], "GENERATED_FROM", ours["SPDXID"]) for file in listed),
               *((other["SPDXID"], kind, ours["SPDXID"]) for other, (*_, kind, _) in zip(others, OTHERS))]
    content = hashlib.sha256(json.dumps([ours, others, listed]).encode()).hexdigest()[:32]
    now = int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
            "name": f"ahv-{ours['versionInfo']}",
            "documentNamespace": f"https://spdx.org/spdxdocs/ahv-{ours['versionInfo']}-{content}",
            "creationInfo": {"created": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(now)),
                             "creators": [f"Tool: ahv-{ours['versionInfo']}"]},
            "packages": [ours, *others], "files": listed,
            "relationships": [{"spdxElementId": one, "relationshipType": kind, "relatedSpdxElement": other}
                              for one, kind, other in related]}


if __name__ == "__main__":
    for path in write(Path(sys.argv[1])):
        print(path)
