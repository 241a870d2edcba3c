"""A campaign that is told to end, killed, or without room: everything is over soon, and what was flown is kept."""
import errno
import os
import shutil
import signal
import subprocess
import time

import psutil
import pyarrow.parquet as pq
import pytest
from campaigns import fly_here, load, tables, written
from places import AHV

from cosim.campaign import store as stores
from cosim.campaign import worker
from cosim.campaign.receipt import Receipt
from cosim.campaign.resume import prepare
from cosim.campaign.store import Store
from cosim.campaign.worker import LoadedSystems, Request
from cosim.errors import RunError, UsageError

SOON_S = 10.0  # about 1 s on an idle machine


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """(campaign file, its tables)."""
    folder = tmp_path_factory.mktemp("whole")
    file = written(folder, runs=32, stop=40, runs_per_task=1)
    store = Store(folder / "out", load(file))
    store.folder.mkdir()
    prepare(store, False, "")
    fly_here(store, folder / "fmus")
    store.finish()
    return file, tables(store.folder)


def until(true, limit=120.0):
    end = time.monotonic() + limit
    while not true():
        assert time.monotonic() < end
        time.sleep(0.005)


MOMENTS = {
    "begun": lambda out, count: (out / "parts" / ".campaign").exists(),
    "starting workers": lambda out, count: (out / "parts").exists() and count() >= 3,
    "flying": lambda out, count: len(list((out / "parts").glob("receipt-*"))) >= 3,
}


@pytest.mark.parametrize("moment", [moment if moment == "flying" else pytest.param(moment, marks=pytest.mark.slow)
                                    for moment in MOMENTS])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL,
                                    pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
def test_everything_ends_soon_and_resume_goes_on(whole, tmp_path, number, moment):
    file, expected = whole
    out, temporary = tmp_path / "out", tmp_path / "temporary"
    temporary.mkdir()
    words = [AHV, "campaign", file, "--out", out, "--workers", "2"]
    client = subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                              env={**os.environ, "TMPDIR": str(temporary)})
    process = psutil.Process(client.pid)
    until(lambda: MOMENTS[moment](out, lambda: len(process.children())) or client.poll() is not None)
    assert client.poll() is None
    started = process.children(recursive=True)
    client.send_signal(number)
    printed, said = client.communicate(timeout=SOON_S)
    _, alive = psutil.wait_procs(started, SOON_S)
    assert alive == []
    if number == signal.SIGKILL:
        assert client.returncode == -number
    else:
        assert client.returncode == 128 + number and printed == ""
        assert said == "ahv: Interrupted; what was flown until then is kept, and --resume continues.\n"
        assert list(temporary.iterdir()) == []
        assert not list(out.rglob("*.partial"))
    kept = list((out / "parts").glob("receipt-*"))
    for path in kept:
        receipt = Receipt.read(path)
        assert pq.read_table(out / "parts" / f"runs-{receipt.first:010d}.parquet").num_rows == 2
    subprocess.run([*words, "--resume"], check=True, stdout=subprocess.DEVNULL,
                   env={**os.environ, "TMPDIR": str(temporary)})
    assert tables(out) == expected and list(temporary.iterdir()) == []
    assert not (out / "parts").exists() and not list(out.rglob("*.partial"))


FULL = """
set -e
mkdir $OUT/disk
mount -t tmpfs -o size=64m tmpfs $OUT/disk
ahv="$BIN/ahv campaign $FILE --out $OUT/disk/out --workers 1"
$ahv 2>$OUT/said & client=$!
for i in $(seq 6000); do ls $OUT/disk/out/parts/receipt-* >$OUT/kept 2>/dev/null && break; sleep 0.02; done
dd if=/dev/zero of=$OUT/disk/filler bs=4096 2>/dev/null || true
status=0; wait $client || status=$?
rm $OUT/disk/filler
echo $status >$OUT/status
ls $OUT/disk/out/parts >$OUT/left
$ahv --resume
cp -r $OUT/disk/out $OUT/out
"""


def test_a_disk_that_is_full_ends_with_one_sentence_and_resume_goes_on(whole, tmp_path):
    isolated = ["unshare", "-Urm"]
    if not shutil.which("unshare") or subprocess.run([*isolated, "true"], capture_output=True).returncode:
        pytest.skip("needs user namespaces")
    done = subprocess.run([*isolated, "bash", "-c", FULL], capture_output=True, text=True, timeout=300, env={
        **os.environ, "BIN": str(AHV.parent), "FILE": str(whole[0]), "OUT": str(tmp_path)})
    assert done.returncode == 0, done.stderr
    said = (tmp_path / "said").read_text()
    assert (tmp_path / "status").read_text() == "1\n"
    assert len(said.splitlines()) == 1 and ("No space left on device" in said or "is full" in said)
    assert "what was flown until then is kept, and --resume continues" in said
    assert (tmp_path / "left").read_text().count("receipt-") >= (tmp_path / "kept").read_text().count("receipt-") > 0
    assert tables(tmp_path / "out") == whole[1]


def test_a_part_that_cannot_be_written_is_one_sentence(whole, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "any")

    store = Store(tmp_path, load(whole[0]))
    prepare(store, False, "")
    monkeypatch.setattr(stores.pq, "write_table", full)
    with pytest.raises(RunError, match=r"cannot be written: No space left on device; what was flown until then is"):
        fly_here(store, tmp_path / "fmus")
    assert store.done == {} and not list(store.parts.glob("*-*"))


@pytest.mark.parametrize("number,raised", [(errno.ENOSPC, True), (errno.EDQUOT, True), (errno.ENOENT, False)])
def test_a_full_disk_of_a_worker_is_no_property_of_the_run(tmp_path, monkeypatch, number, raised):
    def ready(*_):
        try:
            raise OSError(number, "any")
        except OSError:
            raise UsageError("The archive is damaged.") from None

    systems = LoadedSystems(None, tmp_path)
    monkeypatch.setattr(systems, "ready", ready)
    request = Request(0, "law", {}, {}, False, False)
    if raised:
        with pytest.raises(RunError, match="is full"):
            systems.fly(request)
    else:
        assert systems.fly(request).status == "error"
    assert worker.disk_is_full(None) is False
