"""Pictures to latents, for the closed loop and for whole stores; no training here."""

from __future__ import annotations

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from pipeline.learning.device import Compute
from pipeline.worldmodel.vae import Vae, last_convolution, last_matrix

BATCH = 256


class Encoder:
    """A frozen VAE's encoder, from bytes.

    The division by 255 is folded into the first kernel, and weights are laid out and cast once.

    Args:
        vae: the network; not changed.
        compute: where and in which precision.
    """

    def __init__(self, vae: Vae, compute: Compute) -> None:
        self._compute = compute
        first = vae.conv1.weight.detach() / 255
        self._kernels = [self._laid_out(w) for w in (first, vae.conv2.weight, vae.conv3.weight)]
        layers = ("conv1", "conv2", "conv3", "conv4")
        *self._biases, self._last_bias = (self._cast(vae.get_parameter(f"{name}.bias")) for name in layers)
        self._last = self._cast(last_matrix(vae.conv4.weight)).contiguous()
        self._head = self._cast(torch.cat([vae.mean.weight, vae.log_variance.weight]))
        self._head_bias = self._cast(torch.cat([vae.mean.bias, vae.log_variance.bias]))

    def __call__(self, pictures_uint8: np.ndarray | Tensor) -> Tensor:
        """Posterior means (n, 32), float32, on the CPU, of bytes (n, 64, 64, 3)."""
        return self.posterior(pictures_uint8)[0]

    @torch.inference_mode()
    def latents(self, pictures_uint8: Tensor) -> Tensor:
        """Posterior means (n, 32), float32, of bytes (n, 64, 64, 3), left where the network computes."""
        return self._both(pictures_uint8).chunk(2, dim=1)[0]

    @torch.inference_mode()
    def posterior(self, pictures_uint8: np.ndarray | Tensor) -> tuple[Tensor, Tensor]:
        """Posterior means and log variances, each (n, 32), float32, of bytes (n, 64, 64, 3)."""
        mean, log_variance = self._both(torch.as_tensor(pictures_uint8)).cpu().chunk(2, dim=1)
        return mean, log_variance

    def _both(self, pictures_uint8: Tensor) -> Tensor:
        """Posterior means beside log variances, (n, 64), float32, left where the network computes."""
        return torch.cat([self._encode(part) for part in pictures_uint8.split(BATCH)]).float()

    def _encode(self, part: Tensor) -> Tensor:
        hidden = part.to(self._compute.device).permute(0, 3, 1, 2).to(self._compute.dtype)
        for kernel, bias in zip(self._kernels, self._biases, strict=True):
            hidden = F.relu_(F.conv2d(hidden, kernel, bias, stride=2))
        hidden = F.relu(last_convolution(hidden, self._last, self._last_bias))
        return F.linear(hidden.flatten(1), self._head, self._head_bias)

    def _cast(self, weight: Tensor) -> Tensor:
        return weight.detach().to(self._compute.device, self._compute.dtype)

    def _laid_out(self, weight: Tensor) -> Tensor:
        return self._cast(weight).contiguous(memory_format=torch.channels_last)
