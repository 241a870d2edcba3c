"""Which code flies: a hash over our own files, and the versions of the packages that decide on a flight's numbers."""
import hashlib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("fmpy", "numpy")


def own(folder: Path) -> str:
    """SHA-256 of the Python and C files below `folder`, names and contents."""
    digest = hashlib.sha256()
    for path in sorted((*folder.rglob("*.py"), *folder.rglob("*.c"))):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(folder).as_posix()} {len(content)}\n".encode() + content)
    return digest.hexdigest()


def package(name: str) -> str:
    """The version of an installed package, or `none`."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


# Read with the modules: a process that runs on while its files change goes on with the code that it has.
CODE = {"cosim": own(Path(__file__).parents[1]), **{name: package(name) for name in PACKAGES}}


def code() -> dict[str, str]:
    """The code of this process, by name; a cluster's processes are asked for it."""
    return CODE


def differences(found: Any, wanted: dict[str, str]) -> str:
    """What `found` has other than `wanted`, in words; empty if nothing is."""
    found = found if isinstance(found, dict) else {}
    return ", ".join(f"{name} {str(found.get(name, 'unknown'))[:12]} there, {value[:12]} here"
                     for name, value in wanted.items() if found.get(name) != value)
