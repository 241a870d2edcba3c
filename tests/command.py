"""The command line carried out in this process, for tests that need no process of their own."""
import contextlib
import io
import subprocess

from cosim.cli.app import done


class Text(io.TextIOWrapper):
    """A text that is kept, whose bytes can be written too."""

    def __init__(self):
        super().__init__(io.BytesIO(), encoding="utf-8", newline="\n", write_through=True)

    def __str__(self):
        return self.buffer.getvalue().decode()


def carried_out(*words, cwd=None):
    """`ahv` with `words`, in the folder `cwd`: what subprocess.run gives for it."""
    words, said, complained = list(map(str, words)), Text(), Text()
    with contextlib.ExitStack() as stack:
        stack.enter_context(contextlib.redirect_stdout(said))
        stack.enter_context(contextlib.redirect_stderr(complained))
        if cwd is not None:
            stack.enter_context(contextlib.chdir(cwd))
        try:
            status = done(words)
        except SystemExit as end:
            status = int(end.code or 0)
    return subprocess.CompletedProcess(words, status, str(said), str(complained))


def ahv(*words, cwd=None, status=0):
    """Standard output of `ahv`, which must end with `status`; standard error if that is not 0."""
    ended = carried_out(*words, cwd=cwd)
    assert ended.returncode == status, ended.stderr
    return ended.stdout if status == 0 else ended.stderr
