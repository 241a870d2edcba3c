"""The XML files of SSP: parsed without document types, and validated against the standard's schemas."""
import re
from functools import cache
from pathlib import Path
from typing import Any
from xml.parsers import expat

import fmpy
from lxml import etree

from ..errors import UsageError
from .notes import note

SSD, SSC, SSV, SSM = (f"{{http://ssp-standard.org/SSP1/SystemStructure{part}}}"
                      for part in ("Description", "Common", "ParameterValues", "ParameterMapping"))
OSP = "{http://opensimulationplatform.com/SSP/OSPAnnotations}"

# Root element -> (schema, what it is).
DOCUMENTS = {
    SSD + "SystemStructureDescription": ("SystemStructureDescription.xsd", "system structure description"),
    SSV + "ParameterSet": ("SystemStructureParameterValues.xsd", "parameter set"),
    SSM + "ParameterMapping": ("SystemStructureParameterMapping.xsd", "parameter mapping"),
}
LARGEST = 100_000_000  # bytes of one XML file
LISTS = ("Connectors", "Elements", "Connections", "ParameterBindings", "Units", "Enumerations", "Annotations")
Node = Any             # an lxml element


@cache
def schema(name: str) -> Any:
    """One of the standard's schemas, as fmpy ships them."""
    return etree.XMLSchema(etree.parse(str(Path(fmpy.__file__).parent / "ssp" / "schema" / name)))


def parse(data: bytes, where: str, root: str) -> Node:
    """The root element of the document `data`, which must be a valid `root` (a key of DOCUMENTS).

    `where` names the document in messages. Raises UsageError.
    """
    if len(data) > LARGEST:
        raise UsageError(f"{where} is larger than {LARGEST // 1_000_000} MB.")
    refuse_document_type(data, where)
    try:
        node = etree.fromstring(data, etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True))
    except etree.XMLSyntaxError as error:
        raise UsageError(f"{where} is not well-formed XML: {error}.") from None
    return valid(node, where, root)


def valid(node: Node, where: str, root: str) -> Node:
    """`node` itself. Raises UsageError unless it is a valid `root`."""
    schema_name, kind = DOCUMENTS[root]
    if node.tag != root:
        raise UsageError(f"{where} is not an SSP 1.0 {kind}: its root element is {short(node.tag)}.")
    version = node.get("version", "1.0")
    if not version.startswith("1."):
        raise UsageError(f"{where} is an SSP {version} {kind}; SSP 1.0 is what runs here.")
    checker = schema(schema_name)
    checker.validate(node)
    for error in checker.error_log:
        if not harmless(error):
            raise UsageError(f"{where}, line {error.line}, is not a valid SSP 1.0 {kind}: {short(error.message)}")
        note(f"{where}, line {error.line}: {short(error.message)} That is ignored.")
    return node


def harmless(error: Any) -> bool:
    """Whether an error can be ignored: tools write attributes that are not in the standard, and empty lists."""
    empty = re.match(r"Element '\{.*\}(\w+)': Missing child", error.message)
    return error.type_name == "SCHEMAV_CVC_COMPLEX_TYPE_3_2_1" or bool(empty and empty[1] in LISTS)


def refuse_document_type(data: bytes, where: str) -> None:
    """Raises UsageError for a document type, which no SSP needs and in which entities can grow without bound."""
    def refuse(*_: Any) -> None:
        raise UsageError(f"{where} declares a document type (DOCTYPE), which no file of an SSP needs; it is not read.")

    reader = expat.ParserCreate()
    reader.StartDoctypeDeclHandler = refuse
    try:
        reader.Parse(data, True)
    except (expat.ExpatError, ValueError, LookupError) as error:  # LookupError: an unknown encoding
        raise UsageError(f"{where} is not well-formed XML: {error}.") from None


def short(text: str) -> str:
    """`text` on one line, without the namespaces of its elements."""
    return re.sub(r"\{[^}]*\}", "", " ".join(text.split()))
