"""The FMUs' C as WebAssembly, in wasmtime and in node: docs/wasm.md."""
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from native_host import run

from cosim.vehicle.registry import MODELS

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples" / "wasm"
MOST = 1 << 20  # bytes of all modules together

wasm_host = pytest.importorskip("wasm_host", reason="no wasmtime: pip install wasmtime", exc_type=ImportError)
pytestmark = pytest.mark.slow  # zig compiles a C library at first


@pytest.fixture(scope="module")
def case(native_fmus, tmp_path_factory):
    return wasm_host.case1(tmp_path_factory.mktemp("wasm"), "neural", 100)


def test_all_modules_together_are_small_and_import_nothing(native_fmus):
    modules = [wasm_host.module(native_fmus[name]) for name in MODELS]
    assert sum(map(len, modules)) < MOST
    for content in modules:
        assert not wasm_host.Compiled(wasm_host.Engine(), content).imports


def test_case_1_in_wasmtime_to_the_last_bit(case):
    rows = wasm_host.flown(case.system)
    assert len(rows) == 10001 and np.array_equal(rows, case.rows)


@pytest.mark.skipif(not shutil.which("node"), reason="no node: apt-get install nodejs")
@pytest.mark.parametrize("law", ["neural", "resilient", "backstepping"])
def test_case_1_in_node_to_the_last_bit(native_fmus, law, tmp_path):
    case = wasm_host.case1(tmp_path, law, 100)
    (tmp_path / "system.json").write_text(json.dumps(case.system))
    rows = [json.loads(line) for line in run("node", EXAMPLES / "fly.mjs", tmp_path / "system.json").splitlines()]
    assert len(rows) == 10001 and np.array_equal(rows, case.rows)


@pytest.mark.skipif(not shutil.which("node"), reason="no node: apt-get install nodejs")
def test_what_is_refused_is_said(case, tmp_path):
    case.system["components"]["controller"]["values"] = {"k_gamma": -1.0}
    (tmp_path / "system.json").write_text(json.dumps(case.system))
    done = subprocess.run(["node", EXAMPLES / "fly.mjs", tmp_path / "system.json"], capture_output=True, text=True)
    assert done.returncode and "k_gamma = -1" in done.stderr and "is below its minimum" in done.stderr
