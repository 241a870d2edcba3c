"""Notes to the user on stderr, about what does not stop a run."""
import sys


def note(text: str) -> None:
    """Write one line to stderr."""
    print(f"ahv: {text}", file=sys.stderr)
