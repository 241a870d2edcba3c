"""Native FMUs for model exchange, as fmpy loads them, integrated together by fmpy's CVode."""
import ctypes
import shutil
from pathlib import Path
from types import SimpleNamespace

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model
from fmpy.sundials import CVodeSolver

NO_INPUT = SimpleNamespace(apply=lambda time: None)


class Member:
    """One FMU of either version, in continuous time once it has begun."""

    def __init__(self, path: Path):
        self.folder = Path(fmpy.extract(str(path)))
        self.description = fmpy.read_model_description(str(self.folder), validate=False)
        self.fmi3 = self.description.fmiVersion.startswith("3")
        variables = {v.name: v for v in self.description.modelVariables}
        self.reference = {name: v.valueReference for name, v in variables.items()}
        self.states = [self.name_of_state(unknown.variable) for unknown in self.description.derivatives]
        self.nominal = np.array([float(variables[name].nominal or 1.0) for name in self.states])
        make = FMU3Model if self.fmi3 else FMU2Model
        token = self.description.guid or self.description.instantiationToken
        self.fmu = make(guid=token, unzipDirectory=str(self.folder), modelIdentifier=path.stem, instanceName=path.stem)
        self.fmu.instantiate()
        self.n = len(self.states)

    def name_of_state(self, rate):
        state = rate.derivative
        return state.name if hasattr(state, "name") else self.description.modelVariables[int(state)].name

    def close(self):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)

    def set(self, **values):
        (self.fmu.setFloat64 if self.fmi3 else self.fmu.setReal)([self.reference[k] for k in values],
                                                                  list(map(float, values.values())))

    def get(self, *names):
        return (self.fmu.getFloat64 if self.fmi3 else self.fmu.getReal)([self.reference[name] for name in names])

    def begin(self, booleans=(), at_start=(), **parameters):
        """Into continuous time; `at_start` are inputs."""
        self.fmu.reset()
        for name, value in booleans:
            self.fmu.setBoolean([self.reference[name]], [value])
        self.set(**parameters)
        if not self.fmi3:
            self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.set(**dict(at_start))
        self.fmu.exitInitializationMode()
        self.to_continuous_time()

    def to_continuous_time(self):
        self.fmu.updateDiscreteStates() if self.fmi3 else self.fmu.newDiscreteStates()
        self.fmu.enterContinuousTimeMode()

    @property
    def x(self):
        found = (ctypes.c_double * self.n)()
        self.fmu.getContinuousStates(found, self.n)
        return np.array(found)

    def put(self, x):
        self.fmu.setContinuousStates((ctypes.c_double * self.n)(*x), self.n)

    @property
    def rate(self):
        found = (ctypes.c_double * self.n)()
        (self.fmu.getContinuousStateDerivatives if self.fmi3 else self.fmu.getDerivatives)(found, self.n)
        return np.array(found)


def solve(members, seconds, rtol, wire=lambda: None):
    """The states of all members after `seconds` from 0 on; `wire` passes outputs on to inputs."""
    cuts = np.cumsum([0, *(member.n for member in members)])
    n, refused = int(cuts[-1]), []

    def vector(pointer):
        return np.ctypeslib.as_array(pointer, (n,))

    def get_x(pointer, _):
        vector(pointer)[:] = np.concatenate([member.x for member in members])

    def set_x(pointer, _):
        for member, low, high in zip(members, cuts, cuts[1:]):
            member.put(vector(pointer)[low:high])

    def get_rate(pointer, _):
        vector(pointer)[:] = 0.0
        if refused:
            return
        try:  # an exception does not pass through the solver, which goes to its end without changes then
            wire()
            vector(pointer)[:] = np.concatenate([member.rate for member in members])
        except Exception as error:
            refused.append(error)

    def get_nominals(pointer, _):
        vector(pointer)[:] = np.concatenate([member.nominal for member in members])

    def set_time(time):
        for member in members:
            member.fmu.setTime(time)

    solver = CVodeSolver(n, 0, get_x, set_x, get_rate, lambda *_: None, get_nominals, set_time, NO_INPUT, 0.0,
                         relativeTolerance=rtol, maxNumSteps=10_000)
    try:
        solver.step(0.0, seconds)
    finally:
        if refused:
            raise refused[0]
    return np.concatenate([member.x for member in members])
