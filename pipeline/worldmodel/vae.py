"""The convolutional VAE of Ha and Schmidhuber (2018): 64 × 64 RGB pictures to 32 latents.

The parameters are those of the published network; the computation is an equal one with less work:

- Pictures are *folded*: each 2 × 2 block of pixels becomes one place with 12 channels, so the first
  convolution (stride 2, 3 channels) is one of stride 1 over 12; the last transposed one (stride 2,
  3 channels) is a plain convolution to 4 × 4 blocks of 48: channels fill the processor's vectors.
- The last convolution, of 6 × 6 places to 2 × 2, and the first transposed one, of a 1 × 1 picture,
  are written as the matrix products that they are, on weights as they lie in memory: to rearrange
  millions of weights takes longer than to multiply by them.
- Transposed convolutions add their bias afterwards: oneDNN adds it six times as slowly in bfloat16.
"""

from __future__ import annotations

from pathlib import Path

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from pipeline.contract.errors import BelvedereError
from pipeline.learning import checkpoints
from pipeline.worldmodel import pictures

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
        self.decoder_input = nn.Linear(LATENTS, 1024)
        self.deconv1 = nn.ConvTranspose2d(1024, 128, 5, 2)
        self.deconv2 = nn.ConvTranspose2d(128, 64, 5, 2)
        self.deconv3 = nn.ConvTranspose2d(64, 32, 6, 2)
        self.deconv4 = nn.ConvTranspose2d(32, 3, 6, 2)
        for layer in self.children():
            if layer is not self.deconv1:  # its weight is a matrix
                layer.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def encode(self, pictures: Tensor) -> tuple[Tensor, Tensor]:
        """Posterior mean and log variance, each (n, 32), of pictures (n, 3, 64, 64) in [0, 1]."""
        return self.encode_folded(F.pixel_unshuffle(pictures, 2))

    def decode(self, latents: Tensor) -> Tensor:
        """Pictures (n, 3, 64, 64) in [0, 1] of latents (n, 32)."""
        return F.pixel_shuffle(pictures.folded(self.decode_blocks(latents)), 2)

    def encode_folded(self, folded: Tensor) -> tuple[Tensor, Tensor]:
        """The same of folded pictures (n, 12, 32, 32)."""
        first = folded_convolution(self.conv1.weight)
        hidden = F.relu(F.conv2d(folded, first, self.conv1.bias))
        hidden = F.relu(self.conv2(hidden))
        hidden = F.relu(self.conv3(hidden))
        hidden = F.relu(last_convolution(hidden, last_matrix(self.conv4.weight), self.conv4.bias)).flatten(1)
        return self.mean(hidden).float(), self.log_variance(hidden).float()

    def decode_blocks(self, latents: Tensor) -> Tensor:
        """Pictures in [0, 1] as :func:`pictures.blocks`, (n, 16, 16, 2, 24), of latents (n, 32)."""
        hidden = self.decoder_input(latents) @ self.deconv1.weight.view(1024, -1)
        hidden = hidden.view(-1, 128, 5, 5).contiguous(memory_format=torch.channels_last)
        hidden = F.relu(_biased(hidden, self.deconv1))
        for layer in (self.deconv2, self.deconv3):
            hidden = F.conv_transpose2d(hidden, layer.weight, stride=2)
            hidden = F.relu(_biased(hidden, layer))
        weight = blocked_deconvolution(self.deconv4.weight.to(hidden.dtype))
        bias = _bias(self.deconv4).repeat_interleave(4).repeat(4)
        decoded = torch.sigmoid(F.conv2d(hidden, weight, bias, stride=2, padding=2).float())
        return decoded.permute(0, 2, 3, 1).unflatten(3, (2, 24))


def _bias(layer: nn.ConvTranspose2d) -> Tensor:
    assert layer.bias is not None
    return layer.bias


def _biased(hidden: Tensor, layer: nn.ConvTranspose2d) -> Tensor:
    return hidden + _bias(layer).to(hidden.dtype)[:, None, None]


def folded_convolution(weight: Tensor) -> Tensor:
    """Kernel (o, 12, 2, 2), stride 1, on folded pictures, equal to (o, 3, 4, 4), stride 2."""
    out = weight.shape[0]
    return weight.reshape(out, 3, 2, 2, 2, 2).permute(0, 1, 3, 5, 2, 4).reshape(out, 12, 2, 2)


def last_matrix(weight: Tensor) -> Tensor:
    """Kernel (o, i, 4, 4) as the matrix (o, 16 · i) of :func:`last_convolution`; a view, channels last."""
    return weight.permute(0, 2, 3, 1).flatten(1)


def last_convolution(hidden: Tensor, matrix: Tensor, bias: Tensor | None) -> Tensor:
    """A convolution (4 × 4, stride 2) of places (n, i, 6, 6) to (n, o, 2, 2)."""
    places = hidden.permute(0, 2, 3, 1)
    seen = [places[:, row : row + 4, column : column + 4] for row in (0, 2) for column in (0, 2)]
    patches = torch.stack(seen, dim=1).flatten(2).unflatten(1, (2, 2))
    return F.linear(patches, matrix, bias).permute(0, 3, 1, 2)


def blocked_deconvolution(weight: Tensor) -> Tensor:
    """Kernel (48, i, 4, 4), stride 2, padding 2, equal to a transposed (i, 3, 6, 6), stride 2.

    A place of its output is a block of 4 × 4 pixels: two places, in each direction, of the
    transposed convolution's 2 × 2 phases; each phase sees 3 × 3 inputs, the two together 4 × 4.
    """
    inputs = weight.shape[0]
    taps = weight.reshape(inputs, 3, 3, 2, 3, 2).flip(2, 4).permute(1, 3, 5, 0, 2, 4)
    kernel = weight.new_zeros(2, 2, 3, 2, 2, inputs, 4, 4)  # place down and across, colour, phase down, …
    for down in range(2):
        for across in range(2):
            kernel[down, across, :, :, :, :, down : down + 3, across : across + 3] = taps
    return kernel.reshape(48, inputs, 4, 4).contiguous(memory_format=torch.channels_last)


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
