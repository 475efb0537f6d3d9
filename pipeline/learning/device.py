"""Where and in which precision networks run: decided by the machine, never by params.yaml."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass

import torch

from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.machine import cores

DEVICE_VARIABLE = "BELVEDERE_DEVICE"
DTYPE_VARIABLE = "BELVEDERE_DTYPE"


@dataclass(frozen=True)
class Compute:
    """A place to compute.

    Attributes:
        device: CPU or CUDA.
        dtype: of matrix products and convolutions; weights and losses are always float32.
        threads: CPU threads of one operation.
    """

    device: torch.device
    dtype: torch.dtype
    threads: int

    def autocast(self) -> AbstractContextManager[object]:
        """The context in which a network's forward pass runs."""
        return torch.autocast(self.device.type, self.dtype, enabled=self.dtype != torch.float32)

    def facts(self) -> dict[str, object]:
        """What decides the last bits of a result, for keys and provenance."""
        return {
            "device": self.device.type,
            "dtype": str(self.dtype).removeprefix("torch."),
            "threads": self.threads,
            "torch": torch.__version__,
        }


@contextmanager
def one_thread() -> Iterator[None]:
    """Within it torch's CPU operations use one thread: small networks lose more to sharing than they gain."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def compute() -> Compute:
    """The place that the environment chooses; sets torch's CPU threads.

    ``BELVEDERE_DEVICE`` is ``auto``, ``cpu`` or ``cuda``; ``BELVEDERE_DTYPE`` is ``auto``,
    ``float32`` or ``bfloat16``; ``BELVEDERE_CORES`` is the number of threads (else all cores).

    Raises:
        BelvedereError: a variable has another value, or there is no CUDA device.
    """
    device = _device(_choice(DEVICE_VARIABLE, ("auto", "cpu", "cuda")))
    name = _choice(DTYPE_VARIABLE, ("auto", "float32", "bfloat16"))
    dtype = _fast_dtype(device) if name == "auto" else getattr(torch, name)
    threads = cores()
    torch.set_num_threads(threads)
    return Compute(device, dtype, threads)


def _choice(variable: str, valid: tuple[str, ...]) -> str:
    name = os.environ.get(variable) or "auto"
    if name not in valid:
        raise unknown(f"{variable} (in the environment)", name, valid)
    return name


def _device(name: str) -> torch.device:
    if name == "cuda" and not torch.cuda.is_available():
        raise BelvedereError(f"{DEVICE_VARIABLE}=cuda, but torch finds no CUDA device; use auto or cpu.")
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    return torch.device(name)


def _fast_dtype(device: torch.device) -> torch.dtype:
    """bfloat16 where the hardware multiplies in it; elsewhere it is emulated and slower than float32."""
    if device.type == "cuda":
        return torch.bfloat16 if torch.cuda.is_bf16_supported(including_emulation=False) else torch.float32
    return torch.bfloat16 if torch.cpu.get_capabilities().get("amx_bf16") else torch.float32
