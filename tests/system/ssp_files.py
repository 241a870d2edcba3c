"""Small SSP files for tests: text around `Gain.fmu`."""
import functools
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

NAMESPACES = " ".join(f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{part}"' for prefix, part in (
    ("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"), ("ssm", "ParameterMapping")))
HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'

UNITS = """<ssd:Units>
    <ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>
    <ssc:Unit name="km"><ssc:BaseUnit m="1" factor="1000"/></ssc:Unit>
    <ssc:Unit name="s"><ssc:BaseUnit s="1"/></ssc:Unit>
    <ssc:Unit name="K"><ssc:BaseUnit K="1"/></ssc:Unit>
    <ssc:Unit name="degC"><ssc:BaseUnit K="1" offset="273.15"/></ssc:Unit>
    <ssc:Unit name="degF"><ssc:BaseUnit K="1" factor="0.5555555555555556" offset="255.3722222222222"/></ssc:Unit>
  </ssd:Units>"""


@functools.cache
def gain() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(__file__).parent / "gain.py"
        subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", source, "-d", folder], check=True,
                       capture_output=True)
        return (Path(folder) / "Gain.fmu").read_bytes()


def in_unit(unit):
    return f' unit="{unit}"' if unit else ""


def connector(name, kind, unit=None):
    return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real{in_unit(unit)}/></ssd:Connector>'


def component(name, u=None, y=None, bindings="", source="resources/Gain.fmu", more=""):
    """A Gain whose u and y are in these units."""
    return (f'<ssd:Component name="{name}" source="{source}"><ssd:Connectors>{connector("u", "input", u)}'
            f'{connector("y", "output", y)}{more}</ssd:Connectors>{bound(bindings)}</ssd:Component>')


def bound(bindings):
    return f"<ssd:ParameterBindings>{bindings}</ssd:ParameterBindings>" if bindings else ""


def connection(start, end, inner="", **attributes):
    """From and to `element.connector`, or `.connector` for the system's own."""
    words = {}
    for side, (element, _, name) in (("start", start.rpartition(".")), ("end", end.rpartition("."))):
        words |= {f"{side}Element": element} if element else {}
        words[f"{side}Connector"] = name
    text = " ".join(f'{key}="{value}"' for key, value in (words | attributes).items())
    return f"<ssd:Connection {text}>{inner}</ssd:Connection>"


def linear(factor, offset):
    return f'<ssc:LinearTransformation factor="{factor}" offset="{offset}"/>'


def system(name, elements, connections="", connectors="", bindings=""):
    links = f"<ssd:Connections>{connections}</ssd:Connections>" if connections else ""
    own = f"<ssd:Connectors>{connectors}</ssd:Connectors>" if connectors else ""
    return (f'<ssd:System name="{name}">{own}{bound(bindings)}<ssd:Elements>{elements}</ssd:Elements>{links}'
            f'</ssd:System>')


def ssd(inner, experiment='<ssd:DefaultExperiment stopTime="1"/>', version="1.0"):
    return (f'{HEAD}<ssd:SystemStructureDescription {NAMESPACES} name="test" version="{version}">{inner}{UNITS}'
            f'{experiment}</ssd:SystemStructureDescription>')


def parameter(name, value, type_="Real", unit=None):
    return f'<ssv:Parameter name="{name}"><ssv:{type_} value="{value}"{in_unit(unit)}/></ssv:Parameter>'


def parameters(*entries):
    return (f'<ssv:ParameterSet {NAMESPACES} name="p" version="1.0"><ssv:Parameters>{"".join(entries)}'
            f'</ssv:Parameters>{UNITS.replace("ssd:", "ssv:")}</ssv:ParameterSet>')


def mapping(*entries):
    return f'<ssm:ParameterMapping {NAMESPACES} version="1.0">{"".join(entries)}</ssm:ParameterMapping>'


def inline(*entries, mapped="", **attributes):
    """A binding with its values, and its mapping if there is one, in place."""
    text = "".join(f' {key}="{value}"' for key, value in attributes.items())
    mapped = f"<ssd:ParameterMapping>{mapped}</ssd:ParameterMapping>" if mapped else ""
    return (f'<ssd:ParameterBinding{text}><ssd:ParameterValues>{parameters(*entries)}</ssd:ParameterValues>{mapped}'
            f'</ssd:ParameterBinding>')


def write(path, description, **files):
    """The SSP at `path` with Gain.fmu and more `files`, called as they are with __ for / and _dot_ for a dot."""
    contents = {"SystemStructure.ssd": description, "resources/Gain.fmu": gain()}
    contents |= {name.replace("__", "/").replace("_dot_", "."): data for name, data in files.items()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in contents.items():
            if data is not None:
                archive.writestr(name, data)
    return path
