"""The convolutional VAE of Ha and Schmidhuber (2018): 64 × 64 RGB pictures to 32 latents.

The parameters are those of the published network; the computation is an equal one with less work:

- Pictures are *folded*: each 2 × 2 block of pixels becomes one place with 12 channels, so the first
  convolution (stride 2, 3 channels) is one of stride 1 over 12, and the last transposed one
  (stride 2, 3 channels) is a plain convolution to 12: channels fill the processor's vectors.
- The last convolution, of 6 × 6 places to 2 × 2, is written as the matrix product that it is.
- Between z and the first transposed convolution (of a 1 × 1 picture, so a matrix product) the
  published decoder has a linear layer and no nonlinearity: the two matrices are multiplied first.
"""

from __future__ import annotations

from pathlib import Path

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from pipeline.contract.errors import BelvedereError
from pipeline.learning import checkpoints

LATENTS = 32
SIZE = 64


class Vae(nn.Module):
    """Encoder and decoder; parameter names and shapes as published (4,348,547 in all)."""

    def __init__(self) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(3, 32, 4, 2)
        self.conv2 = nn.Conv2d(32, 64, 4, 2)
        self.conv3 = nn.Conv2d(64, 128, 4, 2)
        self.conv4 = nn.Conv2d(128, 256, 4, 2)
        self.mean = nn.Linear(1024, LATENTS)
        self.log_variance = nn.Linear(1024, LATENTS)
        self.spread = nn.Linear(LATENTS, 1024)
        self.deconv1 = nn.ConvTranspose2d(1024, 128, 5, 2)
        self.deconv2 = nn.ConvTranspose2d(128, 64, 5, 2)
        self.deconv3 = nn.ConvTranspose2d(64, 32, 6, 2)
        self.deconv4 = nn.ConvTranspose2d(32, 3, 6, 2)
        self.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def encode(self, pictures: Tensor) -> tuple[Tensor, Tensor]:
        """Posterior mean and log variance, each (n, 32), of pictures (n, 3, 64, 64) in [0, 1]."""
        return self.encode_folded(F.pixel_unshuffle(pictures, 2))

    def decode(self, latents: Tensor) -> Tensor:
        """Pictures (n, 3, 64, 64) in [0, 1] of latents (n, 32)."""
        return F.pixel_shuffle(self.decode_folded(latents), 2)

    def encode_folded(self, folded: Tensor) -> tuple[Tensor, Tensor]:
        """The same of folded pictures (n, 12, 32, 32)."""
        hidden = F.relu(F.conv2d(folded, folded_convolution(self.conv1.weight), self.conv1.bias))
        hidden = F.relu(self.conv2(hidden))
        hidden = F.relu(self.conv3(hidden))
        hidden = F.relu(last_convolution(hidden, last_matrix(self.conv4.weight), self.conv4.bias))
        hidden = hidden.flatten(1)
        return self.mean(hidden).float(), self.log_variance(hidden).float()

    def decode_folded(self, latents: Tensor) -> Tensor:
        """Folded pictures (n, 12, 32, 32) in [0, 1] of latents (n, 32)."""
        hidden = F.relu(self._first_deconvolution(latents))
        hidden = F.relu(self.deconv2(hidden))
        hidden = F.relu(self.deconv3(hidden))
        weight, bias = folded_deconvolution(self.deconv4.weight, _bias(self.deconv4))
        return torch.sigmoid(F.conv2d(hidden, weight, bias, padding=2).float())

    def _first_deconvolution(self, latents: Tensor) -> Tensor:
        """deconv1(spread(latents)) with the two matrices multiplied first: (n, 128, 5, 5)."""
        matrix = self.deconv1.weight.permute(0, 2, 3, 1).reshape(1024, -1)  # a view: channels last
        weight = self.spread.weight.t() @ matrix
        bias = torch.addmm(_bias(self.deconv1).repeat(25)[None], self.spread.bias[None], matrix)
        hidden = torch.addmm(bias, latents, weight)
        return hidden.view(-1, 5, 5, 128).permute(0, 3, 1, 2)


def _bias(layer: nn.ConvTranspose2d) -> Tensor:
    assert layer.bias is not None
    return layer.bias


def folded_convolution(weight: Tensor) -> Tensor:
    """Kernel (o, 12, 2, 2), stride 1, on folded pictures, equal to (o, 3, 4, 4), stride 2."""
    out = weight.shape[0]
    return weight.reshape(out, 3, 2, 2, 2, 2).permute(0, 1, 3, 5, 2, 4).reshape(out, 12, 2, 2)


def last_matrix(weight: Tensor) -> Tensor:
    """Kernel (o, i, 4, 4) as the matrix (o, 16 · i) of :func:`last_convolution`."""
    out, channels = weight.shape[:2]
    return weight.reshape(out, channels, 2, 2, 2, 2).permute(0, 2, 4, 3, 5, 1).reshape(out, -1)


def last_convolution(hidden: Tensor, matrix: Tensor, bias: Tensor | None) -> Tensor:
    """A convolution (4 × 4, stride 2) of places (n, i, 6, 6) to (n, o, 2, 2)."""
    count, channels = hidden.shape[:2]
    blocks = hidden.permute(0, 2, 3, 1).reshape(count, 3, 2, 3, 2, channels)
    blocks = blocks.permute(0, 1, 3, 2, 4, 5).reshape(count, 3, 3, 4 * channels)
    seen = [blocks[:, row : row + 2, column : column + 2] for row in range(2) for column in range(2)]
    return F.linear(torch.cat(seen, dim=-1), matrix, bias).permute(0, 3, 1, 2)


def folded_deconvolution(weight: Tensor, bias: Tensor) -> tuple[Tensor, Tensor]:
    """Kernel (12, i, 3, 3) and bias, padding 2, equal to a transposed (i, 3, 6, 6), stride 2."""
    taps = weight.reshape(weight.shape[0], 3, 3, 2, 3, 2).flip(2, 4)
    return taps.permute(1, 3, 5, 0, 2, 4).reshape(12, -1, 3, 3), bias.repeat_interleave(4)


def kl_nats(mean: Tensor, log_variance: Tensor) -> Tensor:
    """KL divergence, in nats, of each posterior (n, 32) from the standard normal: (n,)."""
    return -0.5 * (1 + log_variance - mean.square() - log_variance.exp()).sum(1)


def load_vae(path: Path) -> Vae:
    """The network whose weights ``pipeline.vae`` wrote to ``path``.

    Raises:
        BelvedereError: the file is missing, truncated or foreign.
    """
    vae = Vae()
    try:
        vae.load_state_dict(checkpoints.load(path, "vae"))
    except RuntimeError:
        raise BelvedereError(
            f"{path} holds no weights of a VAE; delete it and run `dvc repro vae`."
        ) from None
    return vae.eval().requires_grad_(False)
