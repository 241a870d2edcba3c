"""What is being called just now, written where a parent process can read it after a crash or a hang.

Without `place` (no isolation) a note is lost at once; `isolated` gives the place.
"""
place: memoryview | None = None


def note(text: str) -> None:
    if place is not None:
        line = text.encode("utf-8", "replace")[:len(place) - 1]
        place[:len(line) + 1] = line + b"\0"
