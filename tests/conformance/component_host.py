"""An FMU's WebAssembly component in wasmtime: the methods of the draft FMI-LS-WASM, by their names there."""
import zipfile
from pathlib import Path

import fmpy
from wasmtime import Engine, Store
from wasmtime.component import Component, Linker

PACKAGE = "fmi:fmi3/{}@3.0.0"


class Compiled:
    """The component of an FMU of FMI 3.0, ready to make instances in."""

    def __init__(self, fmu: Path):
        self.description = fmpy.read_model_description(str(fmu))
        self.names = {v.name: v.valueReference for v in self.description.modelVariables}
        with zipfile.ZipFile(fmu) as archive:
            content = archive.read(f"binaries/wasm32-wasip2/{fmu.stem}.wasm")
        self.token = self.description.guid or self.description.instantiationToken
        self.engine = Engine()
        self.component = Component(self.engine, content)

    def instance(self, kind: str = "co-simulation", token: str | None = None) -> "Instance":
        return Instance(self, kind, token or self.token)


class Instance:
    """A `kind` instance in a store of its own; `said`: what it logged, (instance name, status, category, message)."""

    def __init__(self, compiled: Compiled, kind: str, token: str):
        self.kind, self.compiled, self.said = kind, compiled, []
        self.store = Store(compiled.engine)
        linker = Linker(compiled.engine)
        with linker.root() as root:
            with root.add_instance(PACKAGE.format("types")):
                pass
            with root.add_instance(PACKAGE.format("callbacks")) as callbacks:
                callbacks.add_func("log-message", lambda store, *said: self.said.append(said))
                for name in ("clock-update", "lock-preemption", "unlock-preemption"):
                    callbacks.add_func(name, lambda store: None)
        self.raw = linker.instantiate(self.store, compiled.component)
        self.interface = self.raw.get_export_index(self.store, PACKAGE.format(kind))
        self.functions = {}
        extra = [False, False, []] if kind == "co-simulation" else []
        self.resource = self.function(f"[static]{kind}-instance.instantiate-{kind}")(
            self.store, "the instance", token, "", False, True, *extra)

    def function(self, name: str):
        if name not in self.functions:
            index = self.raw.get_export_index(self.store, name, self.interface)
            assert index is not None, name
            self.functions[name] = self.raw.get_func(self.store, index)
        return self.functions[name]

    def call(self, name: str, *arguments):
        """A method's answer: a status by name, or a value."""
        return self.function(f"[method]{self.kind}-instance.{name}")(self.store, self.resource, *arguments)

    def ok(self, name: str, *arguments):
        """A method's answer, which must be no refusal."""
        answer = self.call(name, *arguments)
        assert answer not in ("warning", "discard", "error", "fatal"), self.said
        return answer

    def set(self, **values: float):
        return self.ok("set-float64", [self.compiled.names[name] for name in values], list(values.values()))

    def get(self, *names: str) -> list[float]:
        return self.ok("get-float64", [self.compiled.names[name] for name in names])

    def drop(self) -> None:
        self.resource.drop(self.store)
