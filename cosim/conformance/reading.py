"""An unpacked FMU as the rules see it, and the careful reading of its modelDescription.xml (sections 2.2 and 2.3)."""
from pathlib import Path

from lxml import etree

from ..errors import UsageError
from ..master.description import Description
from ..master.xml_file import NotXml, fmpy_folder, prolog, root_of
from .subject import Fault, Fmu


class Unusable(Exception):
    """The FMU cannot be judged any further; carries the rule and the fault that say why."""

    def __init__(self, rule: str, fault: Fault):
        super().__init__(fault.found)
        self.rule = rule
        self.fault = fault


def read(path: Path, folder: Path, members: list[str]) -> Fmu:
    """The FMU at `path` that is unpacked in `folder`. Raises Unusable if its modelDescription.xml cannot be read.

    Raises UsageError for FMI 3.0.
    """
    xml = model_description(folder, members)
    encoding = declared_encoding(xml)
    try:
        root = root_of(xml)
    except NotXml as problem:
        raise Unusable("xml.well-formed", Fault("modelDescription.xml", str(problem), "well-formed XML")) from None
    version = root.get("fmiVersion")
    if root.tag == "fmiModelDescription" and version is not None and version.strip() != "2.0":
        if version.strip().startswith("3."):
            raise UsageError(f"{path}: FMI 3.0 is not checked yet.")
        raise Unusable("xml.fmi-version", Fault("fmiVersion", f"'{version}'", "'2.0'"))
    return Fmu(path, folder, members, Description(root), encoding, schema_faults(root))


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


def schema_faults(root: etree._Element) -> list[Fault]:
    """What the schema fmi2ModelDescription.xsd, as fmpy ships it, objects to."""
    file = fmpy_folder() / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
    schema = etree.XMLSchema(etree.parse(str(file)))
    schema.validate(root)
    return [Fault(f"line {entry.line}", entry.message, "what fmi2ModelDescription.xsd allows")
            for entry in schema.error_log]
