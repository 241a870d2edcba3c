"""The native FMUs with another wrapper: their own sources compiled again, for this machine and without optimising."""
import subprocess
import tempfile
from pathlib import Path
from zipfile import ZipFile

COMPILE = ["gcc", "-std=c99", "-O0", "-ffp-contract=off", "-fvisibility=hidden", "-fPIC", "-shared"]


def recompiled(fmu: Path, wrapper: Path) -> Path:
    """`fmu` with the C files in the folder `wrapper` in its sources and in its library; the file is written anew.

    Raises CalledProcessError where they do not compile.
    """
    with ZipFile(fmu) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    changed = {f"sources/{path.name}": path.read_bytes() for path in wrapper.glob("*.[ch]")}
    if any(contents.get(name) != content for name, content in changed.items()):
        contents.update(changed)
        with tempfile.TemporaryDirectory() as folder:
            for name in [name for name in contents if name.startswith("sources/")]:
                Path(folder, Path(name).name).write_bytes(contents[name])
            subprocess.run([*COMPILE, "-o", "library.so", "all.c", "-lm"], cwd=folder, check=True, capture_output=True)
            for platform in ("linux64", "x86_64-linux"):  # as FMI 2.0 and 3.0 call it
                if (name := f"binaries/{platform}/{fmu.stem}.so") in contents:
                    contents[name] = Path(folder, "library.so").read_bytes()
        with ZipFile(fmu, "w") as archive:
            for name, content in contents.items():
                archive.writestr(name, content)
    return fmu
