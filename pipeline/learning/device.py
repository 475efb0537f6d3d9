"""Where and in which precision networks run: decided by the machine, never by params.yaml."""

from __future__ import annotations

import ctypes
import os
import sys
from contextlib import AbstractContextManager
from dataclasses import dataclass

import torch

from pipeline.contract.errors import BelvedereError, unknown

DEVICE_VARIABLE = "BELVEDERE_DEVICE"
DTYPE_VARIABLE = "BELVEDERE_DTYPE"


@dataclass(frozen=True)
class Compute:
    """A place to compute.

    Attributes:
        device: CPU or CUDA.
        dtype: of matrix products and convolutions; weights and losses are always float32.
    """

    device: torch.device
    dtype: torch.dtype

    def autocast(self, recurrent: bool = False) -> AbstractContextManager[object]:
        """The context in which a network's forward pass runs.

        A ``recurrent`` network stays in float32 on CUDA: under autocast cuDNN's LSTM takes float16 whatever
        is asked for, in which its gradients are too small to be told from zero.
        """
        wanted = self.dtype != torch.float32 and not (recurrent and self.device.type == "cuda")
        return torch.autocast(self.device.type, self.dtype, enabled=wanted)

    def facts(self) -> dict[str, object]:
        """What decides the last bits of a result, for keys and provenance."""
        facts: dict[str, object] = {
            "device": self.device.type,
            "dtype": str(self.dtype).removeprefix("torch."),
            "torch": torch.__version__,
        }
        if self.device.type == "cuda":
            facts["gpu"] = (
                f"{torch.cuda.get_device_name(self.device)}, cuDNN {torch.backends.cudnn.version()}"
            )
        return facts


def set_up_torch() -> Compute:
    """Sets torch up in this process; returns the device and precision that the environment chooses.

    ``BELVEDERE_DEVICE`` is ``auto``, ``cpu`` or ``cuda``; ``BELVEDERE_DTYPE`` is ``auto``,
    ``float32`` or ``bfloat16``.

    An operation of torch on the CPU gets one thread: cores are shared out among repeats, shards and
    pictures instead, which loses less to waiting, and sums are the same at any number of cores.

    Raises:
        BelvedereError: a variable has another value, or there is no CUDA device.
    """
    device = _device(_choice(DEVICE_VARIABLE, ("auto", "cpu", "cuda")))
    name = _choice(DTYPE_VARIABLE, ("auto", "float32", "bfloat16"))
    dtype = _fast_dtype(device) if name == "auto" else getattr(torch, name)
    torch.set_num_threads(1)
    torch.backends.cudnn.allow_tf32 = False  # float32 is float32: TF32 keeps 10 bits of 23
    _keep_memory()
    return Compute(device, dtype)


_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # of glibc's mallopt


def _keep_memory() -> None:
    """Asks glibc not to return a step's memory to the system and fetch it page by page in the next."""
    if sys.platform == "linux":
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)  # other C libraries have none
        if mallopt is not None:
            mallopt(_M_MMAP_THRESHOLD, 32 * 2**20)
            mallopt(_M_TRIM_THRESHOLD, 2**30)


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
    able = torch.cpu.get_capabilities()
    return torch.bfloat16 if able.get("amx_bf16") or able.get("avx512_bf16") else torch.float32
