"""Gives a trained student another motor prior, an odometry that knows its gait, other decisions, and another rewording:
what training a student leaves as they are.

    cd hv_policy/weights
    python ../../training/student/set_networks.py CHECKPOINT {motor_prior,odometry,decision,rewording}.safetensors

Evaluate it anew afterwards: it moves otherwise.
"""

from __future__ import annotations

import sys
from pathlib import Path

from safetensors.torch import load_file, save_file

PLACES = {
    "network.prior.": "motor prior",
    "network.odometry.": "odometry",
    "network.decision.": "decisions",
    "network.rewording.": "rewording",
}


def main(checkpoint: str, *networks: str) -> None:
    file = Path(checkpoint) / "model.safetensors"
    weights = load_file(file)
    for (place, name), path in zip(PLACES.items(), networks, strict=True):
        own = {place + key: value for key, value in load_file(path).items()}
        form = {key: value.shape for key, value in weights.items() if key.startswith(place)}
        if any(key not in own or own[key].shape != shape for key, shape in form.items()):
            raise SystemExit(f"error: {path}: is not of the form of the {name} in {file}")
        weights.update(own)
    written = file.with_suffix(".tmp")
    save_file(weights, written, metadata={"format": "pt"})
    written.chmod(file.stat().st_mode)
    written.replace(file)


if __name__ == "__main__":
    if len(sys.argv) != 2 + len(PLACES):
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
