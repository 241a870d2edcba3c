"""SSP 2.0 in the words of SSP 1.0, which all else reads: types by their family, arrays as their elements.

Left out is what says nothing about a flight: meta data, signatures, variants, where things are drawn.
"""
from itertools import product
from math import prod
from typing import Any

from ..errors import UsageError

Node = Any  # an lxml element

FAMILY = {**dict.fromkeys(("Float64", "Float32"), "Real"),
          **dict.fromkeys([f"{sign}Int{size}" for sign in ("", "U") for size in (8, 16, 32, 64)], "Integer")}
LISTS = ("Real", "Integer", "Boolean")   # whose value may be several words
SILENT = ("MetaData", "Signature", "SSDVariant", "Dimension", "ConnectorGeometry")
KINDS = {"structuralParameter": "parameter", "constant": "parameter", "local": "inout", "unspecified": "inout"}


def in_words_of_1(root: Node) -> Node:
    """`root` itself, an element of SSP 2.0, changed. Raises UsageError for what is not supported, by name."""
    for node in [n for n in root.iter() if isinstance(n.tag, str)]:
        name = local(node)
        if name in FAMILY:
            node.tag = node.tag[:-len(name)] + FAMILY[name]
        elif name == "Connector":
            node.set("kind", KINDS.get(node.get("kind"), node.get("kind", "")))
        elif name == "Connection" and (node.get("startIndices") or node.get("endIndices")):
            raise UsageError(f"The connection from {end(node, 'start')} to {end(node, 'end')} chooses elements of "
                             f"arrays by indices, which is not supported; whole arrays and elements such as x[1] are.")
        elif name == "Clock":
            raise UsageError(f"{node.getparent().get('name')} has a Clock, which is not supported.")
    for node in [n for n in root.iter() if isinstance(n.tag, str)]:
        if local(node) == "Parameter" and "ParameterValues" in node.tag:
            expand(node)
    for node in [n for n in root.iter() if isinstance(n.tag, str) and local(n) in SILENT]:
        node.getparent().remove(node)
    root.set("version", "1.0")
    return root


def expand(parameter: Node) -> None:
    """In place of a parameter that is an array, one for each of its elements. Raises UsageError for a wrong number of
    values."""
    values = next((c for c in parameter if isinstance(c.tag, str) and local(c) in (*LISTS, "String")), None)
    if values is None:
        return
    texts = [v.get("value", v.text or "") for v in values if isinstance(v.tag, str) and local(v) == "Value"]
    if not texts and local(values) in LISTS:
        texts = values.get("value", "").split()
    sizes = [d.get("size") for d in parameter if isinstance(d.tag, str) and local(d) == "Dimension"]
    if len(texts) < 2 and not sizes:
        return
    name = parameter.get("name")
    if any(not str(size).isdigit() for size in sizes):
        raise UsageError(f"The parameter {name} has a dimension without a fixed size, which is not supported.")
    shape = [int(size) for size in sizes] or [len(texts)]
    if prod(shape) != len(texts):
        raise UsageError(f"The parameter {name} has {len(texts)} values for {' x '.join(map(str, shape))} elements.")
    parent, place = parameter.getparent(), parameter.getparent().index(parameter)
    parent.remove(parameter)
    for i, (indices, text) in enumerate(zip(product(*map(range, shape)), texts)):
        one = parent.makeelement(parameter.tag, {"name": f"{name}[{','.join(str(k + 1) for k in indices)}]"})
        unit = {"unit": values.get("unit")} if values.get("unit") else {}
        one.append(one.makeelement(values.tag, {"value": text, **unit}))
        parent.insert(place + i, one)


def local(node: Node) -> str:
    """The name of an element without its namespace."""
    return str(node.tag).rpartition("}")[2]


def end(node: Node, side: str) -> str:
    """One end of a connection, as messages call it."""
    return ".".join(x for x in (node.get(f"{side}Element"), node.get(f"{side}Connector")) if x)
