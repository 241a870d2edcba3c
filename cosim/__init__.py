"""Flies FMU files together; knows nothing of what is inside them.

    import cosim

    system = cosim.System([cosim.Component("plant", "Plant.fmu", {"mass": 300.0}),
                           cosim.Component("controller", "Controller.fmu")],
                          [cosim.Connection("plant.h", "controller.h"), cosim.Connection("controller.u", "plant.u")])
    flight = cosim.fly(system, step=0.01, stop=100.0)
    flight["plant.h"], flight.time, flight.to_pandas(), flight.plot("plant.h")

    cosim.load_ssp("loop.ssp"), cosim.check("any.fmu"), cosim.info("any.fmu")

Names are imported when they are first used, so that `import cosim` costs nothing. docs/python.md is the manual.
"""
from importlib import import_module
from typing import TYPE_CHECKING, Any

from .errors import RunError as RunError
from .errors import UsageError as UsageError

if TYPE_CHECKING:
    from .conformance.report import Report as Report
    from .ecosystems.environment import Environment as Environment
    from .ecosystems.function import Function as Function
    from .fitting.fit import Fit as Fit
    from .library import check as check
    from .library import fit as fit
    from .library import fly as fly
    from .master.flight import Flight as Flight
    from .master.fmu import preset as preset
    from .master.info import FmuInfo as FmuInfo
    from .master.info import info as info
    from .master.series import Series as Series
    from .master.system import Component as Component
    from .master.system import Connection as Connection
    from .master.system import System as System
    from .ssp.load import LoadedSsp as LoadedSsp
    from .ssp.load import load_ssp as load_ssp

WHERE = {
    "Component": "master.system", "Connection": "master.system", "System": "master.system",
    "Flight": "master.flight", "Series": "master.series", "fly": "library",
    "LoadedSsp": "ssp.load", "load_ssp": "ssp.load",
    "FmuInfo": "master.info", "info": "master.info", "preset": "master.fmu",
    "Report": "conformance.report", "check": "library", "Fit": "fitting.fit", "fit": "library",
    "Environment": "ecosystems.environment", "Function": "ecosystems.function",
}


def __getattr__(name: str) -> Any:
    if name not in WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = found = getattr(import_module(f".{WHERE[name]}", __name__), name)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *WHERE})
