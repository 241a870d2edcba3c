"""Work for further processes while the first one goes on: what draws a flight can be imported while it flies."""
import contextlib
import gc
import os
import shutil
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import Pipe
from multiprocessing.connection import Connection as End
from pathlib import Path
from typing import Any

from ..processes import PARENT_DEATH, prctl
from ..temporary import Folder
from .interruptions import ASKING
from .publish import Fill

Work = Callable[..., None]  # writes files into a folder, its first argument


class Aside:
    """A process that has prepared itself, or nothing but a promise to do all works here."""

    def __init__(self, works: Sequence[Work], end: End | None = None, folder: Path = Path()):
        self.works, self.end, self.folder = works, end, folder

    def start(self, *arguments: Any) -> Fill:
        """Begin the works with these arguments, which are pickled. What is returned waits for them, and puts their
        files into the folder that it is given; where the process could not do the works, it does them. It raises
        OSError."""
        if self.end is not None:
            threading.Thread(target=self.send, args=(arguments,), daemon=True).start()
        return lambda place: self.finish(place, arguments)

    def send(self, arguments: tuple[Any, ...]) -> None:
        """Send the arguments; they may have to wait until the process has prepared itself."""
        assert self.end is not None
        with contextlib.suppress(OSError):
            self.end.send(arguments)

    def finish(self, place: Path, arguments: tuple[Any, ...]) -> None:
        """The files of all works into the folder `place`. Raises OSError."""
        try:
            done = self.end is not None and self.end.recv()
        except (EOFError, OSError):
            done = False
        if done:
            copy(self.folder, place)
        else:
            for work in self.works:
                work(place, *arguments)


def copy(folder: Path, place: Path) -> None:
    """All files of a folder into another one. Raises OSError for the first that cannot be copied: `shutil.copytree`
    goes on, and raises all that it met as one long text."""
    for path in sorted(folder.rglob("*")):
        target = place / path.relative_to(folder)
        if path.is_dir():
            target.mkdir(exist_ok=True)
        else:
            shutil.copyfile(path, target)


@contextmanager
def aside(wanted: bool, prepare: Callable[[], None], *works: Work) -> Iterator[Aside]:
    """A process, if `wanted`, that calls `prepare` and then does all works at once when it is told what with. It ends
    with the context, and with this process. Raises NoTemporaryFolder."""
    if not wanted:
        yield Aside(works)
        return
    with Folder() as folder:
        ours, theirs = Pipe()
        program = os.getpid()
        process = os.fork()
        if process == 0:
            try:
                ours.close()
                serve(theirs, folder.path, prepare, works, program)
            finally:
                os._exit(1)
        theirs.close()
        with contextlib.suppress(OSError):
            os.setpgid(process, process)
        try:
            yield Aside(works, ours, folder.path)
        finally:
            end(process, ours)


def end(process: int, ours: End) -> None:
    """End the process and its forks; they are gone then, and with them what they had open."""
    with contextlib.suppress(OSError):
        os.killpg(process, signal.SIGKILL)
    os.waitpid(process, 0)
    with contextlib.suppress(EOFError, OSError):
        while True:
            ours.recv()
    ours.close()


def serve(end: End, folder: Path, prepare: Callable[[], None], works: Sequence[Work], program: int) -> None:
    """What the process does: a fork of itself for each work. What goes wrong here goes wrong once more, and is told,
    where the works are done again."""
    with contextlib.suppress(OSError):
        os.setpgid(0, 0)  # here or there, whichever comes first
    for number in ASKING:
        signal.signal(number, signal.SIG_IGN)  # the program decides what a signal ends
    prctl(PARENT_DEATH, signal.SIGKILL)
    gc.disable()  # all memory goes with the process; pictures take a sixth less time
    with contextlib.suppress(Exception):
        prepare()
        arguments = end.recv()
        if os.getppid() == program:
            workers = [begun(work, folder, arguments) for work in works]
            end.send(all([os.waitpid(worker, 0)[1] == 0 for worker in workers]))


def begun(work: Work, folder: Path, arguments: tuple[Any, ...]) -> int:
    """A fork that does one work; its exit status is 0 when that is done."""
    process = os.fork()
    if process:
        return process
    try:
        prctl(PARENT_DEATH, signal.SIGKILL)
        work(folder, *arguments)
        os._exit(0)
    finally:
        os._exit(1)
