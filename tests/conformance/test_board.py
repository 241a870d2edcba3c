"""The controllers' C on an emulated Cortex-M7 without an operating system: benchmarks/board.py, docs/board.md."""
import re

import board
import pytest

from cosim.vehicle.registry import LAWS

STACK = 32 * 1024  # of board.ld

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(board.missing()), reason=board.missing() or "nothing missing")]


@pytest.mark.parametrize("law", LAWS)
def test_a_board_gives_the_hosts_outputs(native_fmus, law, tmp_path):
    """Its arena is closed after initialisation: an allocation would end the flight."""
    flown = board.board(law, tmp_path)
    assert flown.rows == 10001 and flown.difference == 0
    assert 0 < flown.arena < board.ARENA and 0 < flown.stack < STACK / 2
    row = re.search(rf"^\| {law} \| (.*) \|$", board.PAGE.read_text(), re.MULTILINE)[1]
    flash, *_, ram, arena, stack, _ = (float(word.replace(",", "")) for word in row.split(" | "))
    said = pytest.approx([flash, ram, arena, stack], rel=0.05)
    assert [flown.flash, flown.ram, flown.arena, flown.stack] == said, "the page is old: run benchmarks/board.py"


def test_the_page_has_the_flags():
    said = board.PAGE.read_text().split()
    kept_quiet = {"-Wall", "-Wextra", "-s", "-Wl,--print-map"}
    assert {*board.FLAGS, board.ONE_DOOR, *board.LINK} - kept_quiet <= set(said)


def test_the_replay_notices_a_wrong_output(native_fmus, tmp_path, monkeypatch):
    recorded = board.flight

    def altered(law: str, outputs: list[str]):
        rows = recorded(law, outputs)
        rows[5000, len(board.MEASURED + board.COMMANDED) + outputs.index("elevator")] += 1e-6
        return rows

    monkeypatch.setattr(board, "flight", altered)
    assert board.board("neural", tmp_path).difference == pytest.approx(1e-5, rel=1e-3)  # of 0.1 rad
