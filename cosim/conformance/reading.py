"""An unpacked FMU as the rules see it, and the careful reading of its XML files."""
import re
from pathlib import Path

from lxml import etree

from ..master.description import Description
from ..master.xml_file import NotXml, fmpy_folder, prolog, root_of
from .subject import Fault, Fmu

CHECKED = r"2\.0|3\.0(\.\d+)?"
SCHEMAS = {False: "fmi2/fmi2ModelDescription.xsd", True: "fmi3/fmi3ModelDescription.xsd"}


class Unusable(Exception):
    """The FMU cannot be judged any further; carries the rule and the fault that say why, and whose section asks."""

    def __init__(self, rule: str, fault: Fault, version: str = "2.0"):
        super().__init__(fault.found)
        self.version = version
        self.rule = rule
        self.fault = fault


def read(path: Path, folder: Path, members: list[str]) -> Fmu:
    """The FMU at `path` that is unpacked in `folder`. Raises Unusable if its modelDescription.xml cannot be read."""
    xml = model_description(folder, members)
    encoding = declared_encoding(xml)
    try:
        root = root_of(xml)
    except NotXml as problem:
        raise Unusable("xml.well-formed", Fault("modelDescription.xml", str(problem), "well-formed XML")) from None
    version = root.get("fmiVersion")
    if root.tag == "fmiModelDescription" and version is not None and not re.fullmatch(CHECKED, version.strip()):
        asking = "3.0" if version.strip().startswith("3.") else "2.0"
        raise Unusable("xml.fmi-version", Fault("fmiVersion", f"'{version}'", "'2.0' or '3.0'"), asking)
    description = Description(root)
    return Fmu(path, folder, members, description, encoding, schema_faults(root, SCHEMAS[description.flat]))


def model_description(folder: Path, members: list[str]) -> bytes:
    """The bytes of modelDescription.xml. Raises Unusable if it is not at the archive's root."""
    file = folder / "modelDescription.xml"
    if file.is_file():
        return file.read_bytes()
    elsewhere = [name for name in members if name.lower().endswith("modeldescription.xml")]
    found = f"only '{elsewhere[0]}'" if elsewhere else "no such file"
    raise Unusable("archive.model-description",
                   Fault("modelDescription.xml", found, "modelDescription.xml at the archive's root"))


def declared_encoding(xml: bytes) -> str | None:
    """The declared encoding. Raises Unusable for entities and external document types before a parser expands them."""
    found = prolog(xml)
    if found.system:
        raise Unusable("xml.entities", Fault("modelDescription.xml", f"a document type that refers to '{found.system}'",
                                             "no reference to other files"))
    if found.entity:
        raise Unusable("xml.entities", Fault("modelDescription.xml", f"the entity '{found.entity}' is declared",
                                             "no entity declarations"))
    return found.encoding


def schema_faults(root: etree._Element, name: str) -> list[Fault]:
    """What one of the schemas of FMI, as fmpy ships them, objects to."""
    file = fmpy_folder() / "schema" / name
    schema = etree.XMLSchema(etree.parse(str(file)))
    schema.validate(root)
    return [Fault(f"line {entry.line}", entry.message, f"what {file.name} allows") for entry in schema.error_log]


def further_file(fmu: Fmu, name: str, schema: str) -> tuple[etree._Element | None, list[Fault]]:
    """The root of another XML file of the FMU, None if it is not there or cannot be read, and what is wrong with it."""
    file = fmu.folder / name
    if not file.is_file():
        return None, []
    try:
        xml = file.read_bytes()
        declared_encoding(xml)
        root = root_of(xml)
    except (NotXml, Unusable) as problem:
        return None, [Fault(name, str(problem), "well-formed XML without entities")]
    return root, [Fault(f"{name}, {fault.variable}", *fault[1:]) for fault in schema_faults(root, schema)]
