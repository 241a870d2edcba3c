"""Who may work for a campaign, and who may connect: TLS, certificates, and workers with other code."""
import json
import os
import shutil
import signal
import socket
import ssl
import stat
import subprocess
import time
import urllib.error
import urllib.request
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
from campaigns import tables, written
from command import ahv as here
from distributed import Client
from distributed.security import Security
from places import AHV, ROOT
from test_cases import ahv

from cosim.campaign import cluster
from cosim.errors import RunError, UsageError


def until(true, limit=120.0):
    end = time.monotonic() + limit
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def certificates(folder):
    """Files of a CA, which is also the certificate, and of the key."""
    made = Security.temporary()
    (folder / "ca.pem").write_text(made.tls_ca_file)
    (folder / "key.pem").write_text(made.tls_client_key)
    return folder / "ca.pem", folder / "ca.pem", folder / "key.pem"


# --- the cluster on this machine ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    """A client of a cluster on this machine."""
    folder = tmp_path_factory.mktemp("local") / "work"
    with cluster.local(folder, 2, False) as client:
        client.wait_for_workers(2, timeout=60)
        yield client, folder
    assert not folder.exists()


def sockets(process):
    """The ports at which a process and its children listen."""
    return {c.laddr.port for one in (process, *process.children(recursive=True))
            for c in one.net_connections("tcp") if c.status == psutil.CONN_LISTEN}


def test_a_client_without_the_certificate_cannot_connect(local):
    address = local[0].scheduler.address
    assert address.startswith("tls://127.0.0.1:")
    for where, security in ((address.replace("tls", "tcp"), None), (address, Security.temporary())):
        with pytest.raises((OSError, TimeoutError)):
            Client(where, security=security, timeout=2)
    for worker in local[0].nthreads():
        with pytest.raises((OSError, TimeoutError)):
            Client(worker, security=Security.temporary(), timeout=2)


def test_every_port_wants_a_certificate_or_has_nothing_to_say(local):
    ports = sockets(psutil.Process())
    assert len(ports) >= 5
    for port in ports:
        found = []
        for page in ("", "health", "info/main/workers.html", "json/counts.json", "metrics", "status", "api/v1/workers"):
            try:
                urllib.request.urlopen(f"http://127.0.0.1:{port}/{page}", timeout=5)
            except urllib.error.HTTPError as error:
                found.append(error.code)
            except OSError:  # it is no web server
                break
            else:
                pytest.fail(f"port {port} answers /{page}")
        assert set(found) <= {404}
        if not found:
            assert not welcome(port)


def welcome(port):
    """Whether a port lets us say something although we have no certificate."""
    context = ssl._create_unverified_context()
    try:
        with socket.create_connection(("127.0.0.1", port), 5) as plain, context.wrap_socket(plain) as secure:
            secure.sendall(b"hello")
            return bool(secure.recv(1))
    except OSError:
        return False


def test_the_key_is_in_no_argument_or_environment_and_in_no_file_that_others_can_read(local):
    client, folder = local
    key = Path(client.security.tls_client_key)
    assert key.parent.parent == folder and stat.S_IMODE(key.parent.stat().st_mode) == 0o700
    secret = key.read_bytes().splitlines()[5]
    for process in (psutil.Process(), *psutil.Process().children(recursive=True)):
        for name in ("cmdline", "environ"):
            assert secret not in Path(f"/proc/{process.pid}/{name}").read_bytes()
    assert {path.parent for path in folder.rglob("*") if path.is_file() and secret in path.read_bytes()} == {key.parent}


# --- a cluster that is there already --------------------------------------------------------------------------------


class Hosts:
    """A scheduler and workers by hand."""

    def __init__(self, folder, *words, protocol="tcp"):
        folder.mkdir()
        self.folder, self.words, self.processes = folder, words, []
        file = folder / "scheduler.json"
        self.spawn({}, "scheduler", "--host", f"{protocol}://127.0.0.1", "--port", 0, "--no-dashboard",
                   "--scheduler-file", file)
        until(lambda: file.exists() and file.read_text().strip().endswith("}"))
        self.address = json.loads(file.read_text())["address"]

    def spawn(self, environment, *words):
        self.processes.append(subprocess.Popen(
            [AHV.parent / "dask", *map(str, (*words, *self.words))], cwd=self.folder, stderr=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, start_new_session=True, env={**os.environ, **environment}))

    def worker(self, **environment):
        self.spawn(environment, "worker", self.address, "--nthreads", 1, "--no-dashboard", "--local-directory",
                   self.folder / f"host{len(self.processes)}")

    def stop(self):
        for process in self.processes:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture
def hosts(tmp_path):
    made = []
    yield lambda *words, **options: made.append(Hosts(tmp_path / f"hosts{len(made)}", *words, **options)) or made[-1]
    for one in made:
        one.stop()


@pytest.fixture(scope="module")
def other_tree(tmp_path_factory):
    """Our package with a metric that is computed otherwise."""
    folder = tmp_path_factory.mktemp("other")
    shutil.copytree(ROOT / "cosim", folder / "cosim", ignore=shutil.ignore_patterns("__pycache__"))
    file = folder / "cosim" / "vehicle" / "metrics.py"
    file.write_text(file.read_text() + "\nOTHER = 1\n")
    return folder


def test_a_worker_with_other_code_is_refused_by_name_before_anything_flies(hosts, other_tree, tmp_path):
    there = hosts()
    there.worker(PYTHONPATH=str(other_tree))
    file = written(tmp_path, runs=32)
    said = ahv("campaign", file, "--out", tmp_path / "out", "--scheduler", there.address, status=1)
    assert f"ahv: The worker at {there.address.rpartition(':')[0]}:" in said
    assert "has other code and may not fly: cosim " in said and len(said.strip().splitlines()) == 1
    assert not list((tmp_path / "out" / "parts").glob("receipt-*"))


@pytest.mark.slow
def test_a_worker_with_other_code_that_joins_later_is_sent_away_by_name(hosts, other_tree, tmp_path):
    there = hosts()
    there.worker()
    file, out = written(tmp_path, runs=300, stop=40, runs_per_task=1), tmp_path / "out"
    client = subprocess.Popen([AHV, "campaign", file, "--out", out, "--scheduler", there.address], text=True,
                              stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
    until(lambda: list((out / "parts").glob("receipt-*")) or client.poll() is not None)
    there.worker(PYTHONPATH=str(other_tree))
    said = client.communicate(timeout=300)[1]
    assert client.returncode == 0, said
    assert said.count("has other code and may not fly: cosim ") == 1
    ahv("campaign", file, "--out", tmp_path / "expected")
    assert tables(out) == tables(tmp_path / "expected")


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """A campaign of four runs: its file, and the tables that a cluster on this machine leaves."""
    folder = tmp_path_factory.mktemp("expected")
    file = written(folder, runs=4)
    ahv("campaign", file, "--out", folder / "out")
    return file, tables(folder / "out")


def test_a_cluster_with_tls_takes_who_has_the_files(hosts, expected, tmp_path, monkeypatch):
    ca, cert, key = certificates(tmp_path)
    (tmp_path / "stranger").mkdir()
    stranger = certificates(tmp_path / "stranger")
    there = hosts("--tls-ca-file", ca, "--tls-cert", cert, "--tls-key", key, protocol="tls")
    there.worker()
    (file, flown), out = expected, tmp_path / "out"

    def words(address, ca, cert, key):
        return ("campaign", file, "--out", out, "--scheduler", address, "--tls-ca", ca, "--tls-cert", cert,
                "--tls-key", key)

    said = ahv("campaign", file, "--out", out, "--scheduler", there.address, status=2)
    assert "needs certificates: give --tls-ca" in said and len(said.strip().splitlines()) == 1
    monkeypatch.setattr(cluster, "ANSWER_S", 2.0)
    for refused in (("campaign", file, "--out", out, "--scheduler", there.address.replace("tls", "tcp")),
                    words(there.address, *stranger)):
        said = here(*refused, status=1)
        assert "There is no Dask scheduler at" in said and len(said.strip().splitlines()) == 1
    ahv(*words(there.address, ca, cert, key))
    assert tables(out) == flown


@pytest.mark.parametrize("words,sentence", [
    (("--tls-ca", "ca.pem"), "belong together"),
    (("--tls-ca", "ca.pem", "--tls-cert", "ca.pem", "--tls-key", "key.pem"), "are for a --scheduler tls://"),
    (("--scheduler", "tcp://127.0.0.1:1", "--tls-ca", "ca.pem", "--tls-cert", "ca.pem", "--tls-key", "key.pem"),
     "are for a --scheduler tls://..., not tcp://127.0.0.1:1"),
])
def test_tls_options_that_make_no_sense_are_refused(tmp_path, words, sentence):
    assert sentence in here("campaign", written(tmp_path), "--out", tmp_path / "out", *words, status=2)


@pytest.mark.parametrize("address, sentence", [
    ("tls://127.0.0.1:9", "needs certificates"), ("wss://127.0.0.1:9", "needs certificates"),
    ("ucx://127.0.0.1:9", "cannot be reached from here"), ("foo://x:1", "cannot be reached from here"),
    *((word, "is not an address") for word in ("", " ", "tcp://", "tcp://host", "127.0.0.1", ":1", "tcp://:80",
                                               "tcp://host:0", "tcp://host:99999", "host:²", "host:-1", "host:1x")),
])
def test_an_address_that_cannot_be_one_is_refused_at_once(address, sentence):
    with pytest.raises(UsageError, match=sentence), cluster.remote(address, None):
        pass


def test_a_scheduler_that_does_not_answer_is_said_with_the_time_that_it_had(monkeypatch):
    monkeypatch.setattr(cluster, "ANSWER_S", 0.2)
    sentence = r"There is no Dask scheduler at tcp://127\.0\.0\.1:9 .* after 0\.2 s"
    with pytest.raises(RunError, match=sentence), cluster.remote("tcp://127.0.0.1:9", None):
        pass


def test_tls_files_that_cannot_be_used_are_refused(tmp_path):
    ca, cert, key = certificates(tmp_path)
    with pytest.raises(UsageError, match=r"none.pem: there is no such file"):
        cluster.Tls(ca, cert, tmp_path / "none.pem").security()
    key.write_text("nonsense")
    with pytest.raises(UsageError, match="not two certificates and the key of the second"):
        cluster.Tls(ca, cert, key).security()
    (tmp_path / "stranger").mkdir()
    with pytest.raises(UsageError, match="not two certificates and the key of the second"):
        cluster.Tls(ca, cert, certificates(tmp_path / "stranger")[2]).security()


IMPATIENT = "from cosim.campaign import cluster; cluster.ANSWER_S = 2.0; from cosim.cli import main; main()"
NAMESPACES = """
set -e
ip link set lo up
unshare -n sleep 600 & other=$!
trap 'kill $(jobs -p)' EXIT
sleep 0.5
ip link add here type veth peer name there
ip link set there netns $other
ip addr add 10.213.0.1/24 dev here; ip link set here up
on_other() { nsenter -t $other -n "$@"; }
on_other ip addr add 10.213.0.2/24 dev there; on_other ip link set there up; on_other ip link set lo up
tls="--tls-ca-file $CERT/ca.pem --tls-cert $CERT/ca.pem --tls-key $CERT/key.pem"
$BIN/dask scheduler --host tls://10.213.0.1 --port 8786 --no-dashboard $tls 2>/dev/null &
on_other $BIN/dask worker tls://10.213.0.1:8786 --host tls://10.213.0.2 --nthreads 1 --no-dashboard $tls \
    --local-directory $OUT/worker 2>/dev/null &
address="--scheduler tls://10.213.0.1:8786"
sleep 3
on_other $BIN/python -c "$IMPATIENT" campaign $FILE --out $OUT/refused --scheduler tcp://10.213.0.1:8786 \
    2>$OUT/said && exit 1
$BIN/ahv campaign $FILE --out $OUT/flown $address --tls-ca $CERT/ca.pem --tls-cert $CERT/ca.pem --tls-key $CERT/key.pem
"""


@pytest.mark.slow  # half a minute on an idle machine
def test_two_hosts_with_tls(expected, tmp_path):
    isolated = ["unshare", "-Urn"]
    if not shutil.which("ip") or subprocess.run([*isolated, "ip", "link"], capture_output=True).returncode:
        pytest.skip("needs iproute2 and user namespaces")
    certificates(tmp_path)
    done = subprocess.run([*isolated, "bash", "-c", NAMESPACES], capture_output=True, text=True, timeout=300, env={
        **os.environ, "BIN": str(AHV.parent), "CERT": str(tmp_path), "FILE": str(expected[0]), "OUT": str(tmp_path),
        "IMPATIENT": IMPATIENT})
    assert done.returncode == 0, done.stderr
    assert "There is no Dask scheduler at tcp://10.213.0.1:8786" in (tmp_path / "said").read_text()
    assert tables(tmp_path / "flown") == expected[1]
