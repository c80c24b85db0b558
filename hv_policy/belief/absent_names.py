"""Names of things that a picture does not show, to be asked for in it all the same.

Whoever is only ever asked for what is there takes something for it where it is not.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import Tensor

NAMES_ASKED = 24
"""Names of other pictures of a batch that are asked for in each."""
_ALIKE = 0.6
"""From this cosine on two nouns may mean the same."""


def noun_at(words: Sequence[str]) -> int:
    """Which of the words of "the red box that is on the dresser" says what kind of thing it is: the last one before
    "that"."""
    end = words.index("that") if "that" in words else len(words)
    return max(end - 1, 0)


def draw_names(names: Tensor, has_name: Tensor) -> Tensor:
    """(K,) numbers of names, drawn from those of all things (B, T) of a batch that have one, (B, T) bool; of all where
    none has."""
    known = names[has_name] if bool(has_name.any()) else names.flatten()
    return known[torch.randint(len(known), (NAMES_ASKED,), device=names.device)]


def are_absent(asked: Tensor, of_things: Tensor, has_name: Tensor) -> Tensor:
    """(B, K) bool: nothing with a name in one of B pictures is called like name k, or something alike.

    Args:
        asked: (K, F) what the nouns of K names mean.
        of_things: (B, T, F) the same of each picture's things.
        has_name: (B, T) bool.
    """
    alike = F.normalize(of_things.float(), dim=-1) @ F.normalize(asked.float(), dim=-1).T
    return ~((alike > _ALIKE) & has_name[..., None]).any(1)
