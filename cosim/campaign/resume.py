"""What a campaign's folder holds already: checked before anything is added to it."""
import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..master.publish import read
from .code import differences
from .plan import WHOLE_ONLY, key_of
from .receipt import Receipt
from .store import KINDS, Store

MOST_NAMED = 5


def prepare(store: Store, resume: bool, text: str) -> list[str]:
    """Make the folder ready; `text` is the campaign file's. What the reader should know, in sentences.

    Afterwards `store.complete`, `store.done` and `store.front` say what need not be flown. Raises UsageError if there
    is a campaign already, unless `resume` is set and that campaign is the same, with at most as many runs; RunError if
    the folder cannot be written to.
    """
    with store.writing():
        said: list[str] = []
        before: dict[str, Any] = {}
        if store.receipt.exists() or store.file("runs").exists() or any(store.parts.glob("receipt-*")):
            if not resume:
                raise UsageError(f"{store.folder} has a campaign already: --resume continues it, --out puts this one "
                                 f"elsewhere.")
            before = begun(store, said)
            changed = differences(before.get("code"), store.plan.job.code)
            reopened_before(store)
            tables = final_tables(store, key_of(before), said)
            if tables:
                check_not_fewer(store, tables)
                store.look_at(store.file("runs"), 0)
                store.complete = store.plan.campaign.rare is not None or tables.last == store.last
            if changed and not store.complete:
                raise other_campaign(store, f"code has changed since ({changed})")
            if changed:  # campaign.json says what flew them
                said.append(f"Other code flew these runs than draws their report now ({changed}).")
                return said
            if tables and not store.complete:
                store.check_parts()
                store.reopen(tables)
        else:
            store.clear_parts()
        if not store.complete:
            store.check_parts()
            find_parts(store, said)
            if before.get("runs") != store.plan.campaign.runs:
                said += power_of_two(store)
        store.write_head(text)  # before parts/: it says that the folder is a campaign's
        if store.complete:
            store.clear_parts()  # left by a process that was killed after its last file
        else:
            store.mark_parts()
    return said


def power_of_two(store: Store) -> list[str]:
    """The advice for Sobol's sequence, whose first points are balanced where their number is a power of 2."""
    campaign = store.plan.campaign
    above = 1 << (campaign.runs - 1).bit_length()
    if campaign.sampling != "sobol" or campaign.runs == above:
        return []
    return [f"Sobol draws are most even where runs is a power of 2: {above // 2:,} or {above:,} rather than "
            f"{campaign.runs:,}."]


def check_not_fewer(store: Store, receipt: Receipt) -> None:
    """Raises UsageError if the file asks for fewer runs than there are."""
    if receipt.last > (runs := store.plan.campaign.runs):
        raise UsageError(f"{store.folder} has {receipt.last:,} runs already and the file asks for {runs:,}: a campaign "
                         f"can grow, not shrink. Ask for {receipt.last:,} or more, or give another folder with --out.")


def reopened_before(store: Store) -> None:
    """Finish what a killed process began: to make a part of the final tables."""
    try:
        receipt, part = Receipt.read(store.receipt), Receipt.read(store.part_receipt(0))
    except ValueError:
        return
    if receipt == part and not all(store.file(kind).exists() for kind in KINDS):
        store.reopen(receipt)


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
    changed = [name for name in {**ours, **before} if name not in ("code", "runs", "runs_per_task")
               and before.get(name) != ours.get(name)]
    if changed:
        raise other_campaign(store, f"{', '.join(changed)} {'has' if len(changed) == 1 else 'have'} changed since")
    if before.get("runs") != ours["runs"] and (why := WHOLE_ONLY.get(ours["sampling"])):
        raise other_campaign(store, f"runs has changed since, from {before.get('runs')} to {ours['runs']}. {why}")
    return before


def says(path: Path) -> str | None:
    """The key of the campaign that a receipt names; None if there is no receipt."""
    try:
        return Receipt.read(path).campaign
    except ValueError:
        return None


def final_tables(store: Store, key: str, said: list[str]) -> Receipt | None:
    """The receipt of the final tables; None unless they are whole and of the campaign `key`."""
    if not (store.receipt.exists() or store.file("runs").exists()):
        return None
    try:
        receipt = Receipt.read(store.receipt)
        if (receipt.campaign, receipt.first, set(receipt.tables)) != (key, 0, set(KINDS)):
            raise ValueError(f"{store.receipt.name} is not of this campaign")
        wrong = faults(receipt, store.file)
    except ValueError as reason:
        wrong = [str(reason)]
    if wrong:
        said.append(f"{named(wrong)}: what is not in parts/ is flown again.")
        return None
    return receipt


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
    """Find the tasks that are complete. A task with a damaged part is not. Raises UsageError if they have more runs
    than the file asks for."""
    wrong: list[str] = []
    end = 0
    for first in sorted(store.tasks()):
        path = store.part_receipt(first)
        try:
            receipt = Receipt.read(path)
            runs = receipt.tables.get("runs")
            if (receipt.campaign, receipt.first, runs and runs.rows) != (
                    store.plan.job.key, first, (receipt.last - first) * len(store.plan.laws)) or first < end:
                raise ValueError(f"{path.name} is not of this task")
        except ValueError as reason:
            wrong.append(str(reason))
            continue
        found = faults(receipt, partial(store.part, first=first))
        wrong += found
        if not found:
            check_not_fewer(store, receipt)
            end = receipt.last
            store.done[first] = receipt
            store.look_at(store.part("runs", first), first)
    if wrong:
        said.append(f"{store.parts}: {named(wrong)}: these runs are flown again.")


def named(wrong: list[str]) -> str:
    """The first of `wrong`, and how many there are."""
    more = len(wrong) - MOST_NAMED
    return ", ".join(wrong[:MOST_NAMED]) + (f", and {more} more" if more > 0 else "")
