"""What a reader should know although the run goes on."""
import sys


def note(text: str) -> None:
    print(f"ahv: {text}", file=sys.stderr)
