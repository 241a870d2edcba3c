"""Builds the small FMU of small.c, in the variants that tests and measurements need, and wires systems of it."""
import hashlib
import sys
import zipfile
from pathlib import Path

from cosim.master.system import Component, Connection, System, Value
from fmus.native_compiler import cc
from fmus.native_flavour import HEADERS

REALS = ("a11", "a12", "a21", "a22", "b1", "b2", "c1", "c2", "d", "x1", "x2", "substeps", "fault_time", "longest",
         "u", "y", "y1", "y2")
STARTS = {"a12": 1.0, "a21": -1.0, "b2": 1.0, "c1": 1.0, "substeps": 1.0, "fault_time": 1e9, "longest": 1e9}
FAULTS = ("none", "discard", "error", "fatal", "hang", "crash", "refuse_get", "refuse_init", "hang_init", "end",
          "answers", "refuse_text", "no_text", "crash_terminate", "crash_free", "hang_terminate", "fatal_terminate",
          "not_a_number", "leave", "fatal_init", "slow_init", "refuse_free",
          "refuse_set")
START = ' start="{}"'
TRUE = ' {}="true"'
OTHERS = ("fault", "whole_in", "whole_out", "truth_in", "truth_out", "text_in", "text_out", "answer")


def variable(number: int, name: str, kind: str, reference: int, causality: str, start: str = "") -> str:
    variability = {"parameter": "fixed"}.get(causality, "continuous" if kind == "Real" else "discrete")
    initial = {"parameter": ' initial="exact"', "output": ' initial="calculated"'}.get(causality, "")
    return (f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
            f'variability="{variability}"{initial}><{kind}{start and START.format(start)}/>'
            f'</ScalarVariable><!-- {number} -->')


def describe(identifier: str, direct: bool | None, states: bool, interpolates: bool, others: bool,
             any_step: bool = True, claims: tuple[str, ...] = ()) -> str:
    """modelDescription.xml; `direct`: y depends on u, does not, or (None) the FMU does not say; `others`: with
    variables that are not Reals; `claims`: further capabilities."""
    causality = {"u": "input", "y": "output", "y1": "output", "y2": "output"}
    lines = [variable(i, n, "Real", i - 1, causality.get(n, "parameter"),
                      "" if n in ("y", "y1", "y2") else repr(STARTS.get(n, 0.0))) for i, n in enumerate(REALS, 1)]
    at = {n: i for i, n in enumerate((*REALS, *OTHERS), 1)}
    for i, (kind, start) in enumerate((("Integer", "0"), ("Boolean", "false"), ("String", "")) if others else ()):
        name = ("whole", "truth", "text")[i]
        first = 1 if kind == "Integer" else 0
        if kind == "Integer":
            lines.append(variable(at["fault"], "fault", kind, 0, "parameter", "0"))
        given = f'<{kind} start="{start}"/>'
        lines.append(variable(at[f"{name}_in"], f"{name}_in", kind, first, "input").replace(f"<{kind}/>", given))
        lines.append(variable(at[f"{name}_out"], f"{name}_out", kind, first + 1, "output"))
    if others:
        lines.append(variable(at["answer"], "answer", "Integer", 3, "parameter", "0"))
    behind = "" if direct is None else f' dependencies="{at["u"] if direct else ""}"'
    outputs = [(at["y"], behind), (at["y1"], ' dependencies=""'), (at["y2"], ' dependencies=""'),
               *((at[f"{n}_out"], f' dependencies="{at[f"{n}_in"]}"') for n in ("whole", "truth", "text") if others)]
    unknowns = "".join(f'<Unknown index="{i}"{k}/>' for i, k in outputs)
    return (f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="2.0" modelName="{identifier}" '
            f'guid="{{{identifier}}}"><CoSimulation modelIdentifier="small" '
            f'{TRUE.format("canHandleVariableCommunicationStepSize") if any_step else ""}'
            f'{TRUE.format("canGetAndSetFMUstate") if states else ""}'
            f'{TRUE.format("canInterpolateInputs") if interpolates else ""}'
            f'{"".join(TRUE.format(claim) for claim in claims)}/>'
            f'<ModelVariables>{"".join(lines)}</ModelVariables><ModelStructure><Outputs>{unknowns}</Outputs>'
            f'<InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure></fmiModelDescription>\n')


def library(folder: Path, *flags: str, source: str = "small.c") -> Path:
    """The compiled small.c or small3.c, once for each content."""
    code = Path(__file__).with_name(source)
    built = folder / f"{code.stem}_{hashlib.sha256(code.read_bytes() + repr(flags).encode()).hexdigest()[:12]}.so"
    if not built.exists():
        folder.mkdir(parents=True, exist_ok=True)
        cc("-O2", "-shared", "-fPIC", "-w", *flags, f"-I{HEADERS}", code, "-o", built)
    return built


def build(folder: Path, direct: bool | None = False, states: bool = True, interpolates: bool = False,
          others: bool = True, any_step: bool = True, claims: tuple[str, ...] = (),
          flags: tuple[str, ...] = ()) -> Path:
    """Write a variant of the FMU into `folder` and return its path; `flags` are the compiler's."""
    says = {True: "direct", False: "indirect", None: "silent"}[direct]
    identifier = "_".join(["small", says, *(["stateless"] if not states else []),
                           *(["interpolating"] if interpolates else []), *(["reals"] if not others else []),
                           *(["even"] if not any_step else []), *claims])
    path = folder / f"{identifier}.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(library(folder, *flags), "binaries/linux64/small.so")
        archive.writestr("modelDescription.xml",
                         describe(identifier, direct, states, interpolates, others, any_step, claims))
    return path


def oscillator(**changed: Value) -> dict[str, Value]:
    """Values of a mass on a damped spring, pushed by u: x1 its place, x2 its speed."""
    return {"a21": -4.0, "a22": -0.3, "x1": 1.0, **changed}


def pair(left: Path, right: Path | None = None, **changed: Value) -> System:
    """Two oscillators that push each other by what they show."""
    parts = (Component("left", left, oscillator(**changed)),
             Component("right", right or left, oscillator(x1=-0.5, x2=0.2, a21=-9.0)))
    return System(parts, (Connection("left.y", "right.u"), Connection("right.y", "left.u", 0.8)))


def ring(fmu: Path, count: int, closed: bool = True) -> System:
    """`count` oscillators, each pushed by the one before; a chain if not `closed`."""
    names = [f"part{i}" for i in range(count)]
    links = tuple(Connection(f"{a}.y", f"{b}.u", 0.5) for a, b in zip(names, names[1:] + names[:1]))
    return System(tuple(Component(n, fmu, oscillator(x1=1.0 + i)) for i, n in enumerate(names)),
                  links if closed else links[:-1])


if __name__ == "__main__":
    print(build(Path(sys.argv[1])))
