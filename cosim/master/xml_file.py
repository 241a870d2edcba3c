"""The one place that reads XML: documents of unknown origin, and those of SSP, validated against its schemas."""
import re
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from xml.parsers import expat

from lxml import etree

from ..errors import UsageError
from .notes import note
from .ssp2 import in_words_of_1

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
    return etree.XMLSchema(etree.parse(str(fmpy_folder() / "ssp" / "schema" / name)))


def fmpy_folder() -> Path:
    """Where fmpy is, which ships the standards' schemas; fmpy itself is slow to import."""
    spec = find_spec("fmpy")
    return Path(str(spec and spec.origin)).parent


class NotXml(ValueError):
    """A document that cannot be read; the reason."""


@dataclass
class Prolog:
    """What stands before the root element: the declared encoding, whether there is a document type, the file that it
    names, and the first entity that it declares."""
    encoding: str | None = None
    doctype: bool = False
    system: str | None = None
    entity: str | None = None


class RootReached(Exception):
    """Ends the reading of the prolog: the root element begins."""


def prolog(data: bytes) -> Prolog:
    """The prolog of the document `data`, as far as it can be read: `root_of` says what is wrong with it."""
    found = Prolog()

    def declaration(_version: str, encoding: str | None, _standalone: int) -> None:
        found.encoding = encoding

    def doctype(_name: str, system: str | None, *_: object) -> None:
        found.doctype, found.system = True, system

    def entity(name: str, *_: object) -> None:
        found.entity = found.entity or name

    def root(*_: object) -> None:
        raise RootReached

    reader = expat.ParserCreate()
    reader.XmlDeclHandler, reader.StartDoctypeDeclHandler = declaration, doctype
    reader.EntityDeclHandler, reader.StartElementHandler = entity, root
    with suppress(RootReached, expat.ExpatError, LookupError, ValueError, TypeError):  # the latter: odd encodings
        reader.Parse(data, True)
    return found


def root_of(data: bytes) -> Node:
    """The root of a document of unknown origin: no entities, no other files, no comments. Raises NotXml."""
    if len(data) > LARGEST:
        raise NotXml(f"it is larger than {LARGEST // 1_000_000} MB")
    try:
        return etree.fromstring(data, etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False,
                                                      remove_comments=True))
    except (etree.LxmlError, LookupError, ValueError) as error:  # LookupError: an unknown encoding
        raise NotXml(" ".join(str(error).split()) or "it is empty") from None


def parse(data: bytes, where: str, root: str) -> Node:
    """The root element of the document `data`, which must be a valid `root` (a key of DOCUMENTS).

    `where` names the document in messages. Raises UsageError.
    """
    if prolog(data).doctype:  # in it, entities can grow without bound
        raise UsageError(f"{where} declares a document type (DOCTYPE), which no file of an SSP needs; it is not read.")
    try:
        node = root_of(data)
    except NotXml as error:
        raise UsageError(f"{where} is not well-formed XML: {error}.") from None
    return valid(node, where, root)


def valid(node: Node, where: str, root: str) -> Node:
    """`node` itself. Raises UsageError unless it is a valid `root`."""
    schema_name, kind = DOCUMENTS[root]
    if node.tag != root:
        own = short(node.tag) if short(node.tag) != short(root) else f"{node.tag}, of another namespace"
        raise UsageError(f"{where} is not an SSP {kind}: its root element is {own}.")
    version = node.get("version", "1.0")
    if not version.startswith(("1.", "2.")):
        raise UsageError(f"{where} is an SSP {version} {kind}; SSP 1.0 and 2.0 are what runs here.")
    if version.startswith("2."):
        node = in_words_of_1(node)
    checker = schema(schema_name)
    checker.validate(node)
    for error in checker.error_log:
        if not harmless(error):
            raise UsageError(f"{where}, line {error.line}, is not a valid SSP {version} {kind}: {short(error.message)}")
        note(f"{where}, line {error.line}: {short(error.message)} That is ignored.")
    return node


def harmless(error: Any) -> bool:
    """Whether an error can be ignored: tools write attributes that are not in the standard, and empty lists."""
    empty = re.match(r"Element '\{.*\}(\w+)': Missing child", error.message)
    return error.type_name == "SCHEMAV_CVC_COMPLEX_TYPE_3_2_1" or bool(empty and empty[1] in LISTS)


def short(text: str) -> str:
    """`text` on one line, without the namespaces of its elements."""
    return re.sub(r"\{[^}]*\}", "", " ".join(text.split()))
