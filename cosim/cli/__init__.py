"""The command line `ahv`."""
import signal


def main() -> None:
    """Entry point of the program. While it loads, Ctrl-C ends it without a word: there is nothing to tidy up yet."""
    handler = signal.getsignal(signal.SIGINT)
    if handler != signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from .app import main as carry_out

    if handler != signal.SIG_IGN:
        signal.signal(signal.SIGINT, handler)
    carry_out()
