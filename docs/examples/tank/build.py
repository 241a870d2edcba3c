"""Builds Tank.fmu from C and Regulator.fmu from Python, beside this file or into a folder: python build.py [FOLDER]"""
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy

HERE = Path(__file__).parent
folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
library = folder / "Tank.so"
subprocess.run(["cc", "-O2", "-shared", "-fPIC", f"-I{Path(fmpy.__file__).parent / 'c-code'}", HERE / "tank.c", "-o",
                library, "-lm"], check=True)
with zipfile.ZipFile(folder / "Tank.fmu", "w") as archive:
    archive.write(HERE / "modelDescription.xml", "modelDescription.xml")
    archive.write(library, "binaries/linux64/Tank.so")
library.unlink()
subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", HERE / "regulator.py", "-d", folder], check=True)
