"""FMI-LS-REF: parameter sets, experiments and their results that travel in an FMU, of FMI 2.0 or 3.0.

A model may have a folder experiments/NAME/ beside its file, NAME being the model's. Its files travel in the FMU, and
the manifest says what each is, by the end of its name. Experiments are files of MA-HS-Experiments; inputs and results
are tables as CSV, whose columns have the variables' names.
"""
from html import escape
from pathlib import Path
from types import ModuleType
from xml.etree.ElementTree import Element, SubElement, fromstring

from .check_model import ModelError
from .description import xml_bytes

STANDARD, VERSION = "org.fmi-standard.fmi-ls-ref", "1.0.0-beta.1"
ABOUT = "Layered Standard providing information on related files included in an FMU."
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
FOLDER = f"extra/{STANDARD}"
EXPERIMENTS, TABLE, PARAMETERS = "application/x-ma-hs-experiments", "text/csv", "application/x-ssp-parameter-set"

# End of a file's name -> (type, role, what it is; of experiments their own description).
KINDS = {
    "smoke-test.exp": (EXPERIMENTS, "experiment/smoke-test", ""),
    "validation.exp": (EXPERIMENTS, "experiment/validation", ""),
    "uncertainty-analysis.exp": (EXPERIMENTS, "experiment/uncertainty-analysis", ""),
    "-in.csv": (TABLE, "testcase", "inputs over time, s"),
    "-ref.csv": (TABLE, "result", "golden outputs over time, s"),
}


def carried(model: ModuleType) -> dict[str, bytes]:
    """The files in the model's folder of experiments: name -> content. Raises ModelError for one of no kind of
    KINDS."""
    folder = Path(str(model.__file__)).parent / "experiments" / model.NAME
    found = {path.name: path.read_bytes() for path in sorted(folder.glob("*"))} if model.__file__ else {}
    for name in found:
        if not name.endswith(tuple(KINDS)):
            raise ModelError(model, f"{name} in {folder} is no file of experiments, which end in {' or '.join(KINDS)}")
    return found


def related(model: ModuleType) -> list[tuple[str, str, str, str]]:
    """(type, place from the manifest, role, description) of every file that belongs to the model."""
    rows = [(PARAMETERS, f"../../resources/presets/{name}.ssv", "parameter", f"preset {name}")
            for name in model.PRESETS]
    for name, content in carried(model).items():
        kind, role, about = next(KINDS[end] for end in KINDS if name.endswith(end))
        rows.append((kind, name, role, about or fromstring(content).get("description", "")))
    return [*rows, ("text/html", "../../documentation/index.html", "document", "variables, presets and equations")]


def files(model: ModuleType) -> dict[str, bytes]:
    """What the layered standard adds to the model's FMU: path -> content."""
    root = Element("fmiReferences", {"xmlns:fmi-ls": NAMESPACE, "fmi-ls:fmi-ls-name": STANDARD,
                                     "fmi-ls:fmi-ls-version": VERSION, "fmi-ls:fmi-ls-description": ABOUT})
    for kind, source, role, about in related(model):
        SubElement(root, "Related", type=kind, source=source, role=role, description=about)
    return {f"{FOLDER}/fmi-ls-manifest.xml": xml_bytes(root), "documentation/fmi-ls-ref.html": page(model),
            **{f"{FOLDER}/{name}": content for name, content in carried(model).items()}}


def page(model: ModuleType) -> bytes:
    """documentation/fmi-ls-ref.html: the files and how an experiment is run."""
    rows = "\n".join(f"<tr><td>{escape(source)}</td><td>{escape(role)}</td><td>{escape(about)}</td></tr>"
                     for _, source, role, about in related(model))
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{escape(model.NAME)}: related files</title></head><body>
<h1>{escape(model.NAME)}: related files</h1>
<p>As the layered standard FMI-LS-REF {VERSION} has them; places are given from {FOLDER}.</p>
<table><tr><th>file</th><th>role</th><th>what it is</th></tr>
{rows}
</table>
<p>To run an experiment: set the parameters of its parameter set and the inputs of the first row; initialise at the
start time; then take steps of the step size, each with the inputs of the row at its start, held. The outputs after the
step that ends at a row's time agree with the result within the tolerance, as a part of each variable's nominal
value.</p>
</body></html>
""".encode()
