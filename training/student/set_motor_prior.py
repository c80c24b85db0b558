"""Gives a trained student another motor prior: the network below its intents, which it does not train.

    python training/student/set_motor_prior.py CHECKPOINT hv_policy/weights/motor_prior.safetensors

Evaluate it anew afterwards: it moves otherwise.
"""

from __future__ import annotations

import sys
from pathlib import Path

from safetensors.torch import load_file, save_file

PLACE = "network.prior."


def main(checkpoint: str, prior: str) -> None:
    file = Path(checkpoint) / "model.safetensors"
    weights, own = load_file(file), load_file(prior)
    form = {name: value.shape for name, value in weights.items() if name.startswith(PLACE)}
    if form != {PLACE + name: value.shape for name, value in own.items()}:
        raise SystemExit(f"error: {prior}: is not of the form of the motor prior in {file}")
    weights.update({PLACE + name: value for name, value in own.items()})
    written = file.with_suffix(".tmp")
    save_file(weights, written, metadata={"format": "pt"})
    written.replace(file)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
