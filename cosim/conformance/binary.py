"""What a shared library is made for and what it exports, read from its own tables (ELF, PE, Mach-O) without loading it.

Only what section 2.3 needs: the processor, the word size, and the names of the exported functions. A file that claims
tables which it does not hold raises `BadBinary`.
"""
import struct
from dataclasses import dataclass
from pathlib import Path

ELF_MACHINES = {0x03: "x86", 0x3E: "x86_64", 0xB7: "aarch64", 0x28: "arm", 0xF3: "riscv"}
PE_MACHINES = {0x14C: "x86", 0x8664: "x86_64", 0xAA64: "aarch64", 0x1C4: "arm"}
MACH_MACHINES = {0x7: "x86", 0x01000007: "x86_64", 0x0100000C: "aarch64"}


class BadBinary(Exception):
    """The file is no shared library of a known kind, or its tables are broken."""


@dataclass(frozen=True)
class Library:
    """`system` is linux, windows or darwin; `machines` are several for a universal Mach-O."""
    system: str
    machines: frozenset[str]
    exports: frozenset[str]


def read_library(file: Path) -> Library:
    """Read the tables of a shared library."""
    data = file.read_bytes()
    try:
        if data[:4] == b"\x7fELF":
            return elf(data)
        if data[:2] == b"MZ":
            return pe(data)
        if data[:4] in (b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe", b"\xca\xfe\xba\xbe"):
            return mach(data)
    except (struct.error, IndexError, ValueError, OverflowError) as problem:
        raise BadBinary(f"its tables are damaged ({problem})") from None
    raise BadBinary("it is neither ELF (Linux) nor PE (Windows) nor Mach-O (macOS)")


def text(data: bytes, offset: int) -> str:
    """The text at `offset` that a null byte ends."""
    return data[offset : data.index(b"\0", offset)].decode("ascii", "replace")


def elf(data: bytes) -> Library:
    """The dynamic symbol table (SHT_DYNSYM): global or weak symbols that are defined."""
    wide, order = data[4] == 2, "<" if data[5] == 1 else ">"
    machine = struct.unpack_from(order + "H", data, 18)[0]
    section_offset = struct.unpack_from(order + ("Q" if wide else "I"), data, 40 if wide else 32)[0]
    size, count = struct.unpack_from(order + "HH", data, 58 if wide else 46)
    layout = order + ("IIQQQQII" if wide else "IIIIIIII")
    headers = [struct.unpack_from(layout, data, section_offset + i * size) for i in range(count)]
    dynamic = next((h for h in headers if h[1] == 11), None)
    if dynamic is None:
        raise BadBinary("it has no dynamic symbol table")
    strings = headers[dynamic[6]][4]
    names = set()
    step = 24 if wide else 16
    for at in range(dynamic[4], dynamic[4] + dynamic[5], step):
        name, info, section = elf_symbol(data, at, order, wide)
        if section != 0 and info >> 4 in (1, 2):
            names.add(text(data, strings + name))
    return Library("linux", frozenset({ELF_MACHINES.get(machine, hex(machine))}), frozenset(names))


def elf_symbol(data: bytes, at: int, order: str, wide: bool) -> tuple[int, int, int]:
    """(offset of the name, type and binding, section) of the symbol at `at`."""
    if wide:
        name, info, _, section = struct.unpack_from(order + "IBBH", data, at)
    else:
        name, _, _, info, _, section = struct.unpack_from(order + "IIIBBH", data, at)
    return name, info, section


def pe(data: bytes) -> Library:
    """The export directory: the table of names."""
    header = struct.unpack_from("<I", data, 0x3C)[0]
    if data[header:header + 4] != b"PE\0\0":
        raise BadBinary("it begins like a Windows file but has no PE header")
    machine, sections = struct.unpack_from("<HH", data, header + 4)
    optional_size = struct.unpack_from("<H", data, header + 20)[0]
    optional = header + 24
    is_plus = struct.unpack_from("<H", data, optional)[0] == 0x20B
    export_address = struct.unpack_from("<I", data, optional + (112 if is_plus else 96))[0]
    table = [struct.unpack_from("<IIII", data, optional + optional_size + 40 * i + 8) for i in range(sections)]

    def offset(address: int) -> int:
        for size, start, raw_size, raw in table:
            if start <= address < start + max(size, raw_size):
                return raw + address - start
        raise ValueError(f"address {address:#x} lies in no section")

    names: set[str] = set()
    if export_address:
        directory = offset(export_address)
        count = struct.unpack_from("<I", data, directory + 24)[0]
        pointers = offset(struct.unpack_from("<I", data, directory + 32)[0])
        for address in struct.unpack_from(f"<{count}I", data, pointers):
            names.add(text(data, offset(address)))
    return Library("windows", frozenset({PE_MACHINES.get(machine, hex(machine))}), frozenset(names))


def mach(data: bytes) -> Library:
    """The symbol table of each architecture: external symbols that are defined, without the leading underscore."""
    if data[:4] == b"\xca\xfe\xba\xbe":
        count = struct.unpack_from(">I", data, 4)[0]
        slices = [struct.unpack_from(">IIII", data, 8 + 20 * i)[2] for i in range(count)]
    else:
        slices = [0]
    parts = [mach_slice(data, base) for base in slices]
    exports = frozenset.intersection(*(names for _, names in parts))
    return Library("darwin", frozenset(machine for machine, _ in parts), exports)


def mach_slice(data: bytes, base: int) -> tuple[str, frozenset[str]]:
    """(processor, exported names) of the architecture that begins at `base`."""
    wide = data[base:base + 4] == b"\xcf\xfa\xed\xfe"
    cpu, _, _, commands = struct.unpack_from("<IIII", data, base + 4)
    at = base + (32 if wide else 28)
    names = set()
    for _ in range(commands):
        command, size = struct.unpack_from("<II", data, at)
        if size < 8:
            raise ValueError(f"a load command of {size} bytes")
        if command == 2:  # LC_SYMTAB
            symbols, count, strings, _ = struct.unpack_from("<IIII", data, at + 8)
            for i in range(count):
                entry = base + symbols + i * (16 if wide else 12)
                name, kind = struct.unpack_from("<IB", data, entry)
                if kind & 0x01 and kind & 0x0E and not kind & 0xE0:  # external, defined, no debugging entry
                    names.add(text(data, base + strings + name).removeprefix("_"))
        at += size
    return MACH_MACHINES.get(cpu, hex(cpu)), frozenset(names)
