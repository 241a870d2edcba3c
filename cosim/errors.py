"""What can go wrong, in two kinds: the user's words, and the run itself."""


class UsageError(Exception):
    """A request that cannot be carried out as it stands; one sentence. Exit status 2."""


class RunError(Exception):
    """A run that ended early; one sentence that names the FMU, the time and the reason. Exit status 1."""
