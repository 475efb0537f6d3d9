"""What bounds VAE training: the processor's rate of matrix products, and where a step's time goes.

The network needs so many multiplications a picture, forwards and backwards; the processor does so many
a second when it does nothing else. Their quotient is what no implementation in that precision passes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence

import torch
from torch.profiler import ProfilerActivity
from torch.utils.flop_counter import FlopCounterMode

from benchmarks.rows import Row
from pipeline.learning.device import Compute

BOUND = "VAE training, what bounds it, all cores"
SPLIT = "VAE training in one thread, by operation"
SIDE, PRODUCTS, STEPS = 2048, 5, 5
ADAM, REST = "Adam", "rest"
# What each operation of torch counts towards; the first word found in its name decides.
PARTS = {
    "convolution": "convolution",
    "mm": "matrix product",
    "linear": "matrix product",
    "copy_": "copy and cast",
    "cat": "copy and cast",
    "": REST,
}
OPTIMIZER = "Optimizer.step#Adam.step"  # the profiler's name for a step of Adam with all that it calls

Step = Callable[[], object]


def operations_a_picture(step: Step, pictures: int) -> float:
    """Floating-point operations of products and convolutions of one step, by picture of its batch."""
    with FlopCounterMode(display=False) as counter:
        step()
    return counter.get_total_flops() / pictures


def product_rate(place: Compute, run: Callable[[Sequence[Step]], float], threads: int) -> float:
    """Operations a second of matrix products, a product a thread.

    Args:
        place: device and precision.
        run: does steps side by side and says how many seconds they took.
        threads: how many at a time.
    """
    generator = torch.Generator().manual_seed(1)
    factors = [
        torch.randn(2, SIDE, SIDE, generator=generator).to(place.device, place.dtype) for _ in range(threads)
    ]

    def products(pair: torch.Tensor) -> Step:
        return lambda: [pair[0] @ pair[1] for _ in range(PRODUCTS)]

    steps = [products(pair) for pair in factors]
    run(steps)
    return 2.0 * SIDE**3 * PRODUCTS * threads / min(run(steps) for _ in range(3))


def bound_row(form: str, place: Compute, mflop: float, rate: float, reached: float) -> Row:
    """A row of the small table.

    Args:
        form: which network.
        place: the precision of its products.
        mflop: millions of operations that a picture needs.
        rate: operations a second of matrix products.
        reached: pictures a second.
    """
    most = rate / (1e6 * mflop)
    return {
        "table": BOUND,
        "form": form,
        "products in": str(place.dtype).removeprefix("torch."),
        "MFLOP a picture": mflop,
        "GFLOP/s of products": rate / 1e9,
        "so at most pictures/s": most,
        "reached": reached,
        "reached %": 100 * reached / most,
    }


def split_row(form: str, step: Step, pictures: int) -> Row:
    """Microseconds a picture by kind of operation, as torch's profiler counts them in this thread."""
    step()
    with torch.profiler.profile(activities=[ProfilerActivity.CPU]) as profiler:
        for _ in range(STEPS):
            step()
    spent: dict[str, float] = defaultdict(float)
    for event in profiler.key_averages():
        spent[part_of(event.key)] += event.self_cpu_time_total
        if event.key == OPTIMIZER:
            spent[ADAM] = event.cpu_time_total
    spent[REST] -= spent[ADAM]  # what it calls is additions and products by element
    by_part = {part: spent[part] / (STEPS * pictures) for part in dict.fromkeys((*PARTS.values(), ADAM))}
    return {"table": SPLIT, "form": form, "unit": "us a picture", **by_part, "all": sum(by_part.values())}


def part_of(operation: str) -> str:
    """The part that an operation of torch counts towards."""
    return next(part for word, part in PARTS.items() if word in operation.lower())
