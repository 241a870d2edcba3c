"""The nominal flight of each law, before a campaign flies: there every success expression must have a value.

Kinds are checked when the file is read (`criteria`). What only figures show is found here: a metric that a law does not
have, a division by what is 0, a root of what is negative. Such an expression is false for every run, and the campaign
would report 0 %. The whole flight is flown, on the cluster as every run: a few ticks would have errors of 0 and
divisions by 0 that no run has.
"""
from distributed import Client, Future, KilledWorker

from .engine import asking, cannot_fly
from .plan import Plan
from .statistics import JUDGED
from .worker import Outcome, fly_nominal


def check(client: Client, plan: Plan) -> list[str]:
    """Fly each law with nothing drawn and try the success expressions; what could not be tried, in sentences.

    Raises UsageError, with line and field, for an expression without a value; RunError if the cluster is lost.
    """
    flights = {law: client.submit(fly_nominal, plan.job.key, law, pure=False) for law in plan.laws}
    untried = []
    for law, future in flights.items():
        outcome = flown(future)
        if outcome is None or outcome.status not in JUDGED:
            why = "each worker that flew it died" if outcome is None else outcome.message.rstrip(".")
            untried.append(f"The success expressions could not be tried on the nominal flight of {law}: {why}.")
            continue
        for name, reason in outcome.reasons.items():
            text = plan.campaign.success[name]
            plan.source.fail(("success", name), f"'{text}' has no value on the nominal flight of {law}: {reason}")
    return untried


def flown(future: Future) -> Outcome | None:
    """The outcome of a task, None if workers died of it. Raises RunError if the cluster is lost or cannot fly."""
    with asking():
        error = future.exception()
    if error is None:
        with asking():
            return future.result()  # type: ignore[no-any-return]
    if isinstance(error, KilledWorker):
        return None
    raise cannot_fly(error)
