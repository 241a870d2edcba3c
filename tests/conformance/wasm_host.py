"""FMUs as plain WebAssembly modules in wasmtime, and Case 1 as a system of them."""
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from wasmtime import Engine, Instance, Store
from wasmtime import Module as Compiled

from cosim.master.fly import fly
from cosim.vehicle.closed_loop import CLOSED_LOOP, closed_loop
from cosim.vehicle.scenarios import BUILT_IN
from fmus.wasm import module

ORDER = ("scenario", "controller", "plant")
STEP = 0.01


@dataclass
class Case:
    """What docs/examples/wasm/fly.mjs flies, and the same flight of the native FMUs by `ahv`'s master."""
    system: dict
    rows: np.ndarray      # (ticks + 1, outputs)


def native(law: str, stop: float):
    """Case 1 with the native FMUs: its system and its flight."""
    system = closed_loop(BUILT_IN["case1"], law, flavour="native").system
    flown = fly(system, STEP, stop)
    assert flown.finished, flown.message
    return system, flown


def case1(folder: Path, law: str, stop: float) -> Case:
    """Case 1 for `stop` s, its modules compiled into `folder`."""
    system, flown = native(law, stop)
    parts = {part.name: part for part in system.components}
    components = {}
    for name in ORDER:
        file = folder / f"{parts[name].fmu.stem}.wasm"
        file.write_bytes(module(parts[name].fmu))
        outputs = [column.removeprefix(f"{name}.") for column in flown if column.startswith(f"{name}.")]
        components[name] = {"module": str(file), "values": dict(parts[name].values), "outputs": outputs}
    rows = np.column_stack([flown[f"{name}.{o}"] for name in ORDER for o in components[name]["outputs"]])
    links = [(source, target, list(names)) for source, target, names in CLOSED_LOOP]
    return Case({"step": STEP, "stop": stop, "components": components, "connections": links}, rows)


class Ports:
    """Some Real variables of an FMU, to be read and set together."""

    def __init__(self, fmu: "Fmu", names: list[str]):
        self.fmu, self.n = fmu, len(names)
        self.references, self.values = fmu.malloc(4 * self.n), fmu.malloc(8 * self.n)
        fmu.write(self.references, np.array([fmu.names[name] for name in names], "<u4").tobytes())

    def get(self) -> bytes:
        self.fmu.call("GetReal", self.references, self.n, self.values)
        return bytes(self.fmu.memory.read(self.fmu.store, self.values, self.values + 8 * self.n))

    def set(self, values: bytes) -> None:
        self.fmu.write(self.values, values)
        self.fmu.call("SetReal", self.references, self.n, self.values)


class Fmu:
    """An instance of an FMU in a module of its own."""

    def __init__(self, engine: Engine, file: str):
        self.store = Store(engine)
        compiled = Compiled.from_file(engine, file)
        assert not compiled.imports
        self.exports = Instance(self.store, compiled, []).exports(self.store)
        self.memory = self.exports["memory"]
        self.function("_initialize")
        n = self.function("n_variables")
        self.names = {self.text(self.function("variable_name", i)): i for i in range(n)}
        self.c = self.function("instantiate")
        assert self.c, self.message

    def function(self, name: str, *arguments):
        return self.exports[name](self.store, *arguments)

    def malloc(self, size: int) -> int:
        return self.function("malloc", size)

    def write(self, at: int, content: bytes) -> None:
        self.memory.write(self.store, content, at)

    def text(self, at: int) -> str:
        return bytes(self.memory.read(self.store, at, at + 1000)).partition(b"\0")[0].decode()

    @property
    def message(self) -> str:
        return self.text(self.function("message"))

    def call(self, name: str, *arguments) -> None:
        assert self.function(f"fmi2{name}", self.c, *arguments) == 0, self.message

    def begin(self, values: dict) -> None:
        self.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        self.call("EnterInitializationMode")
        for name, value in values.items():
            if isinstance(value, bool):
                at = self.malloc(8)
                self.write(at, np.array([self.names[name], value], "<u4").tobytes())
                self.call("SetBoolean", at, 1, at + 4)
            else:
                Ports(self, [name]).set(np.array([value], "<f8").tobytes())


def flown(system: dict) -> np.ndarray:
    """The rows of `system`, as docs/examples/wasm/fly.mjs flies it: shape (ticks + 1, outputs)."""
    engine = Engine()
    fmus = {name: Fmu(engine, part["module"]) for name, part in system["components"].items()}
    for name, part in system["components"].items():
        fmus[name].begin(part["values"])
    shown = [Ports(fmus[name], part["outputs"]) for name, part in system["components"].items()]
    links = [(target, Ports(fmus[source], names), Ports(fmus[target], names))
             for source, target, names in system["connections"]]

    def tick(advance) -> bytes:
        for name, fmu in fmus.items():
            for target, source_ports, target_ports in links:
                if target == name:
                    target_ports.set(source_ports.get())
            advance(fmu)
        return b"".join(ports.get() for ports in shown)

    rows = [tick(lambda fmu: fmu.call("ExitInitializationMode"))]
    step = system["step"]
    for k in range(round(system["stop"] / step)):
        rows.append(tick(lambda fmu, t=k * step: fmu.call("DoStep", t, step, 1)))
    return np.frombuffer(b"".join(rows), "<f8").reshape(len(rows), -1)
