"""A campaign's folder that was damaged, or that is somebody else's: found, named, flown again or left alone."""
import json
import shutil
import signal
from dataclasses import replace

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from campaigns import campaign, fly_here, load, tables, written

from cosim.campaign import report
from cosim.campaign.plan import key_of
from cosim.campaign.resume import prepare
from cosim.campaign.store import Store
from cosim.errors import RunError, UsageError
from cosim.master.folder import claimed

BAD = 4  # the first run of the task that is damaged


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """(plan, folder with all parts, folder with the final tables)."""
    folder = tmp_path_factory.mktemp("flown")
    plan = load(written(folder, runs=8))
    store = Store(folder / "parts", plan)
    store.folder.mkdir()
    assert prepare(store, False, "text") == []
    fly_here(store, folder / "fmus")
    shutil.copytree(folder / "parts", folder / "done")
    done = Store(folder / "done", plan)
    assert prepare(done, True, "text") == []
    assert sorted(done.done) == [0, 2, 4, 6]
    done.finish()
    assert not done.parts.exists() and pq.read_table(done.file("signals")).num_rows
    return plan, folder / "parts", folder / "done"


@pytest.fixture
def parts(flown, tmp_path):
    shutil.copytree(flown[1], tmp_path / "out")
    return Store(tmp_path / "out", flown[0])


@pytest.fixture
def done(flown, tmp_path):
    shutil.copytree(flown[2], tmp_path / "out")
    return Store(tmp_path / "out", flown[0])


def flip(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def twice(path):
    table = pq.read_table(path)
    pq.write_table(pa.concat_tables([table, table]), path)


def edit(path, **changes):
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))


def of_another_task(store):
    for name in ("runs", "errors", "signals"):
        if store.part(name, 0).exists():
            shutil.copy(store.part(name, 0), store.part(name, BAD))
    shutil.copy(store.part_receipt(0), store.part_receipt(BAD))


DAMAGE = {
    "empty": lambda s: s.part("runs", BAD).write_bytes(b""),
    "cut": lambda s: s.part("errors", BAD).write_bytes(s.part("errors", BAD).read_bytes()[:-100]),
    "one bit": lambda s: flip(s.part("signals", BAD)),
    "missing": lambda s: s.part("runs", BAD).unlink(),
    "signals missing": lambda s: s.part("signals", BAD).unlink(),
    "another task's part": lambda s: shutil.copy(s.part("runs", 0), s.part("runs", BAD)),
    "another task with its receipt": of_another_task,
    "rows twice": lambda s: twice(s.part("runs", BAD)),
    "written twice": lambda s: s.part("runs", BAD).write_bytes(2 * s.part("runs", BAD).read_bytes()),
    "a folder": lambda s: s.part("runs", BAD).unlink() or s.part("runs", BAD).mkdir(),
    "receipt missing": lambda s: s.part_receipt(BAD).unlink(),
    "receipt cut": lambda s: s.part_receipt(BAD).write_bytes(s.part_receipt(BAD).read_bytes()[:40]),
    "receipt of another campaign": lambda s: edit(s.part_receipt(BAD), campaign="0" * 64),
    "receipt without tables": lambda s: edit(s.part_receipt(BAD), tables={}),
    "receipt of another kind": lambda s: s.part_receipt(BAD).write_text("[1, 2]"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_a_damaged_part_is_named_and_flown_again(flown, parts, tmp_path, kind):
    DAMAGE[kind](parts)
    said, = prepare(parts, True, "text")
    assert f"-{BAD:010d}." in said and "flown again" in said and len(said.splitlines()) == 1
    assert sorted(parts.done) == [0, 2, 6]
    if kind == "a folder":
        parts.part("runs", BAD).rmdir()
    fly_here(parts, tmp_path / "fmus")
    parts.finish()
    assert tables(parts.folder) == tables(flown[2])


def test_a_part_that_is_damaged_after_it_was_checked_does_not_come_into_the_tables(parts):
    prepare(parts, True, "text")
    flip(parts.part("runs", BAD))
    with pytest.raises(RunError, match=rf"runs-{BAD:010d}.parquet is damaged; --resume flies its runs again"):
        parts.finish()
    assert not parts.file("runs").exists() and parts.part_receipt(0).exists()


@pytest.mark.parametrize("content", [None, b"", b"{", b"[]", b"\xff\xfe", b"[" * 100_000])
@pytest.mark.parametrize("state", ["parts", "done"])
def test_a_broken_campaign_json_is_named_and_written_anew(flown, request, state, content):
    store = request.getfixturevalue(state)
    before = store.head.read_bytes()
    store.head.unlink() if content is None else store.head.write_bytes(content)
    said, = prepare(store, True, "text")
    assert "campaign.json was missing or damaged" in said
    assert store.head.read_bytes() == before and (store.complete or sorted(store.done) == [0, 2, 4, 6])


@pytest.mark.parametrize("state", ["parts", "done"])
def test_a_folder_without_its_campaign_json_is_still_a_campaigns(request, state):
    store = request.getfixturevalue(state)
    with claimed(store.folder, "campaign", ""):
        pass
    store.head.unlink()
    for _ in range(2):  # the first does not give it up
        with claimed(store.folder, "campaign", ""):
            pass
    with pytest.raises(UsageError, match="holds a campaign"), claimed(store.folder, "run", ""):
        pass


def test_a_broken_campaign_json_and_receipts_of_another_campaign_are_refused(parts):
    parts.head.unlink()
    for path in parts.parts.glob("receipt-*"):
        edit(path, campaign="0" * 64)
    with pytest.raises(UsageError, match="no receipt says that the rest is of this campaign"):
        prepare(parts, True, "text")


@pytest.mark.parametrize("damage,name", [
    (lambda s: shutil.copy(s.file("runs"), s.file("signals")), "signals.parquet is damaged"),
    (lambda s: flip(s.file("errors")), "errors.parquet is damaged"),
    (lambda s: s.file("runs").unlink(), "runs.parquet is missing"),
    (lambda s: s.receipt.unlink(), "receipt.json is missing"),
    (lambda s: s.receipt.write_text("{"), "receipt.json is damaged"),
])
def test_a_damaged_table_is_named_and_its_runs_are_flown_again(flown, done, tmp_path, damage, name):
    damage(done)
    said, = prepare(done, True, "text")
    assert name in said and "flown again" in said and not done.complete and not done.done
    fly_here(done, tmp_path / "fmus")
    done.finish()
    assert tables(done.folder) == tables(flown[2])


def test_a_finished_campaign_is_checked_and_nothing_of_it_changes(flown, done):
    before = {path.name: path.read_bytes() for path in done.folder.iterdir() if path.is_file()}
    assert prepare(done, True, "text") == [] and done.complete
    assert {path.name: path.read_bytes() for path in done.folder.iterdir() if path.is_file()} == before


def with_other_code(plan):
    fingerprint = {**plan.fingerprint, "code": {**plan.fingerprint["code"], "numpy": "1.0"}}
    return replace(plan, fingerprint=fingerprint,
                   job=replace(plan.job, key=key_of(fingerprint), code=fingerprint["code"]))


def test_runs_of_other_code_are_not_continued_but_their_report_can_be_drawn(flown, parts, tmp_path):
    plan = with_other_code(flown[0])
    with pytest.raises(UsageError, match=r"code has changed since \(numpy .* there, 1.0 here\)"):
        prepare(Store(parts.folder, plan), True, "text")
    shutil.copytree(flown[2], tmp_path / "done")
    done = Store(tmp_path / "done", plan)
    said, = prepare(done, True, "text")
    assert done.complete and "Other code flew these runs" in said
    assert json.loads(done.head.read_bytes())["code"] == flown[0].job.code  # that which flew


# --- what is not ours -----------------------------------------------------------------------------------------------


def test_a_folder_parts_of_somebody_else_is_refused_and_left_alone(flown, tmp_path):
    store = Store(tmp_path / "out", flown[0])
    store.parts.mkdir(parents=True)
    (store.parts / "mine.txt").write_text("mine")
    with pytest.raises(UsageError, match="parts has files that are not a campaign's"):
        prepare(store, False, "text")
    assert [path.name for path in store.parts.iterdir()] == ["mine.txt"] and not store.head.exists()


def test_a_file_that_somebody_put_between_the_parts_stays(flown, parts):
    names = ("mine.txt", "runs-1.parquet", "runs-0000000000 (copy).parquet")
    for name in names:
        (parts.parts / name).write_text("mine")
    assert prepare(parts, True, "text") == []
    parts.finish()
    assert sorted(path.name for path in parts.parts.iterdir()) == sorted(names)
    assert tables(parts.folder) == tables(flown[2])


# --- a report that cannot be drawn, a disk that is full -------------------------------------------------------------


def test_a_report_that_cannot_be_drawn_is_drawn_later(flown, done, monkeypatch):
    def fails(*_):
        raise ValueError("no such colour")

    path = flown[0].path
    before = tables(done.folder)
    with monkeypatch.context() as patched:
        patched.setattr(report.charts, "every", fails)
        with pytest.raises(RunError, match=r"could not be drawn \(ValueError: no such colour\).*--resume draws it"):
            campaign(path, done.folder, resume=True)
        assert json.loads((done.folder / "report.json").read_text())["runs"] == 8
        assert not (done.folder / "report.html").exists()
    summary = campaign(path, done.folder, resume=True)
    assert summary["runs_flown_now"] == 0 and (done.folder / "report.html").exists()
    assert tables(done.folder) == before


def test_a_signal_while_parts_are_written_waits_for_their_receipt(parts, monkeypatch):
    prepare(parts, True, "text")
    rows = pq.read_table(parts.part("runs", BAD)).num_rows
    caught = []
    before = signal.signal(signal.SIGTERM, lambda *_: caught.append(parts.part_receipt(BAD).exists()))
    try:
        parts.part_receipt(BAD).unlink()
        write = pq.write_table
        monkeypatch.setattr(pq, "write_table", lambda *words: (write(*words), signal.raise_signal(signal.SIGTERM)))
        monkeypatch.setattr(Store, "signals", lambda *_: parts.schemas["signals"].empty_table())
        monkeypatch.setattr(Store, "table", lambda self, kind, _: pq.read_table(self.part(kind, BAD)))
        parts.add(BAD, [])
    finally:
        signal.signal(signal.SIGTERM, before)
    assert caught == [True] and parts.done[BAD].tables["runs"].rows == rows
