"""Helpers that fly FMU files in tests."""
from contextlib import contextmanager
from ctypes import c_double, c_int
from pathlib import Path

from cosim.master.fmu import FmuFile
from cosim.master.instance import Instance


@contextmanager
def running(path: Path, **values):
    """An initialised instance of the FMU at `path`, with parameters and inputs set before."""
    file = FmuFile.open(path)
    instance = Instance(file, file.description.attributes["modelName"])
    try:
        instance.set({name: file.checked(name, value, "fmu") for name, value in values.items()})
        instance.setup(0.0, 1000.0)
        instance.simple("fmi2EnterInitializationMode")
        instance.simple("fmi2ExitInitializationMode")
        yield instance
    finally:
        instance.close()
        file.close()


def step(instance, time, length):
    instance.check(instance.call("fmi2DoStep", c_double(time), c_double(length), c_int(1)), "fmi2DoStep", time)


def look_on(instance):
    """A master makes no call after Fatal; a test does, to see that a refusal has changed nothing."""
    instance.file.corrupted = False
