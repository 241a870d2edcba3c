"""Probes of memory and files that an FMU does not give back."""
import ctypes
import gc
import mmap
import time
from collections.abc import Callable
from ctypes import c_size_t, c_void_p
from itertools import pairwise
from pathlib import Path

from ..fmi2 import Instance
from .bench import Bench
from .registry import probe

WARM_UP = 20  # cycles after which caches are filled
PARTS = 4  # of the cycles, each of which must grow
LEAST_LEAK = 16  # bytes for each life or run: the smallest block that the C library's allocator gives out
LEAST_PAGES = 256 * 1024  # bytes altogether: less growth of the process is not measured reliably
ENOUGH = 1000  # lives or runs: some caches of an FMU fill for hundreds of them
CACHED_BYTES = range(24, 1033, 16)  # sizes of blocks that glibc keeps for each thread
CACHED_BLOCKS = 16  # of each size: at least as many as it keeps


@probe("memory", many=True)
def memory(bench: Bench) -> None:
    """2.1.5: fmi2FreeInstance frees all memory and other resources, seen over many lives of an instance."""
    handles = open_handles()
    grown, done = growth(bench, lambda: life(bench), "lives of an instance")
    if grown:
        found = f"{grown // done} bytes more for each of {done} lives"
        bench.fault("dynamic.memory", "fmi2FreeInstance", found, "all memory is freed")
    if done and open_handles() - handles >= done:
        found = f"{open_handles() - handles} more open files after {done} lives"
        bench.fault("dynamic.handles", "fmi2FreeInstance", found, "as many as before")


@probe("memory-steps")
def memory_steps(bench: Bench) -> None:
    """2.1.5: stepping does not need ever more memory, seen over many runs of one instance."""
    with bench.instance() as fmu:
        grown, done = growth(bench, lambda: rerun(bench, fmu), "runs with resets between")
    if grown:
        found = f"{grown // done} bytes more for each of {done} runs of {bench.steps} steps, with fmi2Reset between"
        bench.fault("dynamic.memory", "fmi2DoStep", found, "no growth from run to run")


def life(bench: Bench) -> None:
    """One short life of an instance."""
    with bench.instance() as fmu:
        bench.initialize(fmu)
        bench.step(fmu, 0)
        bench.expect(fmu.call("Terminate"), "fmi2Terminate", "after a step")


def rerun(bench: Bench, fmu: Instance) -> None:
    """One run of an instance, then fmi2Reset."""
    bench.initialize(fmu)
    for number in range(bench.steps):
        bench.step(fmu, number)
    bench.expect(fmu.call("Reset"), "fmi2Reset", "after a step")


def growth(bench: Bench, once: Callable[[], None], what: str) -> tuple[int, int]:
    """Do something `cycles` times, or as often as time allows; by how many bytes it grew, and how often it was done.

    A leak grows in every part of the repetitions alike, a cache in the first only: what counts is the least growth.
    What was found in few repetitions has to be found again in ENOUGH, where time allows.
    The allocator's own count tells single bytes. Beside it, the process's memory tells of allocators that are not the
    C library's, from some kilobytes on.
    """
    if not Path("/proc/self/statm").exists():
        bench.skip(f"memory over many {what}", "this system has no /proc")
        return 0, 0
    deadline = time.monotonic() + bench.job.patience
    repeat(once, min(WARM_UP, bench.job.cycles), deadline)
    grown, done = measured(once, bench.job.cycles, deadline)
    if sum(done) < bench.job.cycles:
        bench.skip(f"memory over {bench.job.cycles} {what}", f"slow: {sum(done)} were done in the time for that")
    if grown and all(done) and bench.job.cycles < ENOUGH:
        again, longer = measured(once, ENOUGH, time.monotonic() + bench.job.patience)
        if all(longer):
            grown, done = again, longer
    return (grown if all(done) else 0), sum(done)


def measured(once: Callable[[], None], cycles: int, deadline: float) -> tuple[int, list[int]]:
    """Do something `cycles` times in PARTS, or until the deadline: by how many bytes it grew, and how often it was done
    in each part."""
    counted, resident, done = [allocated_bytes()], [resident_bytes()], []
    for _ in range(PARTS):
        done.append(repeat(once, max(1, cycles // PARTS), deadline))
        counted.append(allocated_bytes())
        resident.append(resident_bytes())
    if not all(done):
        return 0, done
    total = sum(done)
    least = int(total * min((after - before) / n for (before, after), n in zip(pairwise(counted), done, strict=True)))
    half = PARTS // 2
    by_pages = 2 * min(resident[half] - resident[0], resident[-1] - resident[half])
    if least >= LEAST_LEAK * total:
        return least, done
    return (by_pages if by_pages > LEAST_PAGES else 0), done


def repeat(once: Callable[[], None], count: int, deadline: float) -> int:
    """Do something `count` times, or until the deadline; how often it was done."""
    for done in range(count):
        if time.monotonic() > deadline:
            return done
        once()
    return count


class MallInfo(ctypes.Structure):
    """glibc's struct mallinfo2."""
    _fields_ = tuple((name, c_size_t) for name in (
        "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"))


def allocated_bytes() -> int:
    """What the C library's allocator has given out and not got back; 0 where it does not tell."""
    gc.collect()
    try:
        libc = ctypes.CDLL(None)
        tell = libc.mallinfo2
    except (AttributeError, OSError, TypeError):
        return 0
    fill_cache(libc)
    tell.restype = MallInfo
    told = tell()
    return int(told.uordblks + told.hblkhd)


def fill_cache(libc: ctypes.CDLL) -> None:
    """Fill this thread's cache of freed blocks.

    glibc counts the blocks in it as given out. Without this it fills in the course of hundreds of lives, which looks
    like a leak of some bytes for each of them.
    """
    libc.malloc.restype, libc.malloc.argtypes = c_void_p, (c_size_t,)
    libc.free.restype, libc.free.argtypes = None, (c_void_p,)
    for size in CACHED_BYTES:
        for block in [libc.malloc(size) for _ in range(CACHED_BLOCKS)]:
            libc.free(block)


def resident_bytes() -> int:
    """The memory of this process."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE


def open_handles() -> int:
    """How many files this process has open; 0 where the system does not tell."""
    folder = Path("/proc/self/fd")
    return len(list(folder.iterdir())) if folder.exists() else 0
