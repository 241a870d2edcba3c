"""What fmpy and fmutool find in an FMU. Run as a process of its own, because some of these files hang or crash a tool:

python other_tools.py validate FILE...     one JSON object: file -> [found by fmpy, found by fmutool]
python other_tools.py simulate FILE        exit status 0 when fmpy simulates the FMU without complaint
"""

import json
import logging
import sys
import warnings

import fmpy
from fmpy.validation import validate_fmu
from fmu_manipulation_toolbox.checker import get_checkers
from fmu_manipulation_toolbox.operations import FMU


class _Errors(logging.Handler):
    """Counts error messages, which is how `fmutool -check` tells what it found."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += 1


def fmpy_finds(file: str) -> bool:
    """What `fmpy validate FILE` does: a list of problems, or no answer at all."""
    try:
        return bool(validate_fmu(file))
    except Exception:
        return True


def fmutool_finds(file: str) -> bool:
    """What `fmutool -input FILE -check` does: a complaint, or no answer at all."""
    errors = _Errors()
    logger = logging.getLogger("fmu_manipulation_toolbox")
    logger.handlers, logger.propagate = [errors], False
    try:
        with FMU(file) as fmu:
            for checker in get_checkers():
                fmu.apply_operation(checker())
    except Exception:
        return True
    return errors.count > 0


def main(command: str, *files: str) -> None:
    """See above."""
    warnings.simplefilter("ignore")
    if command == "simulate":
        fmpy.simulate_fmu(files[0], stop_time=0.5)
        return
    print(json.dumps({file: [fmpy_finds(file), fmutool_finds(file)] for file in files}))


if __name__ == "__main__":
    main(*sys.argv[1:])
