"""Real time: holds a run back to the wall clock, and says how late it was."""
import time

import numpy as np

SPIN_S = 1e-3   # the end of a wait is a busy loop: sleeping is that inexact
LOOK_S = 0.1


class Pace:
    """Tick k starts no sooner than its simulated time, over `factor`, after the first; late ones catch up."""

    def __init__(self, factor: float, step: float):
        self.factor, self.step = factor, step
        self.begun: float | None = None
        self.late: list[float] = []

    def wait(self, simulated: float, interrupted: list[int]) -> None:
        """Wait until the simulated time (s) is due, or until `interrupted` has an entry."""
        now = time.perf_counter()
        if self.begun is None:
            self.begun = now - simulated / self.factor
        due = self.begun + simulated / self.factor
        while now < due and not interrupted:
            if due - now > SPIN_S:
                time.sleep(min(due - now - SPIN_S, LOOK_S))
            now = time.perf_counter()
        self.late.append(now - due)

    def report(self) -> dict[str, float]:
        """Lateness of the ticks' starts, in s, and the share that started later than one whole step."""
        late = np.array(self.late or [0.0])
        return {"mean_s": float(late.mean()), "p99_s": float(np.quantile(late, 0.99)), "worst_s": float(late.max()),
                "missed": float(np.mean(late > self.step / self.factor))}
