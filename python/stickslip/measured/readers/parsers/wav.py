"""WAV files: the channels as a share of full scale, and the times that the sampling rate gives."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from scipy.io import wavfile


def answer(file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what the file holds, and the columns asked for."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        rate, samples = wavfile.read(file)
    if rate <= 0 or samples.size == 0:
        raise ValueError(f"{samples.size} samples at {rate} Hz")
    samples = samples.reshape(len(samples), -1)
    known = ["t", *(f"channel {i + 1}" for i in range(samples.shape[1]))]
    cut = any("EOF" in str(one.message) for one in said)
    head: dict[str, Any] = {
        "known": known,
        "units": {"t": "s"},
        "facts": [f"{rate} samples a second, {samples.dtype.name}; numbers are shares of full scale"],
        "doubts": ["fewer samples than the header tells of; was the file cut off?"] if cut else [],
    }
    if any(known.count(name) != 1 for name in names):
        return head, []
    every = dict(zip(known, (np.arange(len(samples)) / rate, *_shares(samples).T), strict=True))
    return head, [every[name] for name in names]


def _shares(samples: np.ndarray) -> np.ndarray:
    """Whole numbers as shares of full scale: scipy moves those of 24 bits up to the top of 32."""
    if samples.dtype.kind == "f":
        return samples
    half = 2.0 ** (8 * samples.dtype.itemsize - 1)
    return (samples - half) / half if samples.dtype.kind == "u" else samples / half
