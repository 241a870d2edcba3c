"""What a campaign's folder holds already: checked before anything is added to it."""
import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..master.publish import read
from .code import differences
from .plan import key_of
from .receipt import Receipt
from .store import KINDS, Store

MOST_NAMED = 5


def prepare(store: Store, resume: bool, text: str) -> list[str]:
    """Make the folder ready; `text` is the campaign file's. What was found to be damaged, in sentences.

    Afterwards `store.complete` and `store.done` say what need not be flown. Raises UsageError if there is a campaign
    already, unless `resume` is set and that campaign is the same; RunError if the folder cannot be written to.
    """
    with store.writing():
        said: list[str] = []
        if store.receipt.exists() or store.file("runs").exists() or any(store.parts.glob("receipt-*")):
            if not resume:
                raise UsageError(f"{store.folder} has a campaign already: --resume continues it, --out puts this one "
                                 f"elsewhere.")
            before = begun(store, said)
            changed = differences(before.get("code"), store.plan.job.code)
            store.complete = tables_are_there(store, key_of(before), said)
            if changed and not store.complete:
                raise other_campaign(store, f"code has changed since ({changed})")
            if changed:  # campaign.json says what flew them
                said.append(f"Other code flew these runs than draws their report now ({changed}).")
                return said
        else:
            store.clear_parts()
        if not store.complete:
            store.check_parts()
            find_parts(store, said)
        store.write_head(text)  # before parts/: it says that the folder is a campaign's
        if not store.complete:
            store.mark_parts()
    return said


def other_campaign(store: Store, what: str) -> UsageError:
    """The refusal to continue a campaign, because of `what`."""
    return UsageError(f"{store.folder} has another campaign, which cannot be continued: {what}.")


def begun(store: Store, said: list[str]) -> dict[str, Any]:
    """The fingerprint of the campaign in the folder: the plan's, but for the code.

    Raises UsageError if another campaign is there, or if nothing says which.
    """
    ours = json.loads(store.plan.described)
    before = read(store.head)
    if not before:
        receipts = [store.receipt, *store.parts.glob("receipt-*")]
        if not any(says(path) == store.plan.job.key for path in receipts):
            raise UsageError(f"{store.head} is missing or damaged, and no receipt says that the rest is of this "
                             f"campaign: --out puts this one elsewhere.")
        said.append(f"{store.head} was missing or damaged; it is written anew.")
        return ours
    changed = [k for k, v in ours.items() if before.get(k) != v and k != "code"]
    if changed:
        raise other_campaign(store, f"{', '.join(changed)} {'has' if len(changed) == 1 else 'have'} changed since")
    return before


def says(path: Path) -> str | None:
    """The key of the campaign that a receipt names; None if there is no receipt."""
    try:
        return Receipt.read(path).campaign
    except ValueError:
        return None


def tables_are_there(store: Store, key: str, said: list[str]) -> bool:
    """Whether the final tables are whole and of the campaign `key`."""
    if not (store.receipt.exists() or store.file("runs").exists()):
        return False
    wrong = []
    try:
        receipt = Receipt.read(store.receipt)
        if receipt.campaign != key or set(receipt.tables) != set(KINDS):
            raise ValueError(f"{store.receipt.name} is not of this campaign")
    except ValueError as reason:
        wrong.append(str(reason))
    else:
        wrong += faults(receipt, store.file)
    if wrong:
        said.append(f"{named(wrong)}: what is not in parts/ is flown again.")
    return not wrong


def faults(receipt: Receipt, file: Callable[[str], Path]) -> list[str]:
    """What is wrong with the tables of a receipt, which are at `file`(kind)."""
    wrong = []
    for kind in receipt.tables:
        try:
            receipt.check(kind, file(kind))
        except ValueError as reason:
            wrong.append(str(reason))
    return wrong


def find_parts(store: Store, said: list[str]) -> None:
    """Find the tasks that are complete. A task with a damaged part is not."""
    wrong = []
    for first, last in store.plan.batches():
        path = store.part_receipt(first)
        try:
            receipt = Receipt.read(path)
            expected = store.plan.job.key, first, (last - first) * len(store.plan.laws)
            runs = receipt.tables.get("runs")
            if (receipt.campaign, receipt.first, runs and runs.rows) != expected:
                raise ValueError(f"{path.name} is not of this task")
        except ValueError as reason:
            if path.exists() or any(store.part(kind, first).exists() for kind in KINDS):
                wrong.append(str(reason))
            continue
        found = faults(receipt, partial(store.part, first=first))
        wrong += found
        if not found:
            store.done[first] = receipt
    if wrong:
        said.append(f"{store.parts}: {named(wrong)}: these runs are flown again.")


def named(wrong: list[str]) -> str:
    """The first of `wrong`, and how many there are."""
    more = len(wrong) - MOST_NAMED
    return ", ".join(wrong[:MOST_NAMED]) + (f", and {more} more" if more > 0 else "")
