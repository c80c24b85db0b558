"""Trains a student that believes, and acts with it in many environments at once."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import torch
from torch import Tensor

from hv_policy.batches import Reader, read_instructions, read_observation
from hv_policy.belief import mirror
from hv_policy.belief.belief import BeliefConfig
from hv_policy.belief.floor_patch import read_patches
from hv_policy.belief.labels import FLOOR, LABELS, LANDMARKS, PREFIX, LabelTable, read_landmarks
from hv_policy.belief.perception import Perception
from hv_policy.belief.student import BeliefNetwork, Following
from hv_policy.configuration_hv import HVConfig

SPOTS_A_PICTURE = 2


class BeliefStudent:
    """Trains a `BeliefNetwork` and acts with it; see `hv_policy.modeling_hv.HVPolicy`.

    Args:
        config: the policy's configuration.
        dataset_stats: not needed in this form.
        dataset_meta: LeRobot's metadata of the dataset, for its labels.

    Raises:
        ValueError: there is not exactly one camera, or state and action are not this body's.
    """

    def __init__(
        self, config: HVConfig, dataset_stats: dict[str, dict[str, Any]] | None, dataset_meta: Any | None
    ) -> None:
        assert config.robot_state_feature is not None
        assert config.action_feature is not None
        self.config = config
        self.cameras = sorted(config.image_features)
        sizes = (config.robot_state_feature.shape[0], config.action_feature.shape[0])
        if sizes != (223, 28) or len(self.cameras) != 1:
            raise ValueError(
                f"form: belief is for one camera, a state of 223 and an action of 28, not {len(self.cameras)}, "
                f"{sizes[0]} and {sizes[1]}; valid: form=direct"
            )
        perception = Perception(
            config.perception, config.image_size, config.vocabulary, config.max_words, config.word_dropout
        )
        self.network = BeliefNetwork(perception, from_scratch=config.pretrained_path is None)
        self.reader = Reader(perception.text, self.network.reworder.say)
        self.following: Following | None = None
        """What is carried along while acting."""
        self._meta = dataset_meta
        self._labels: LabelTable | None = None

    def reset(self) -> None:
        """Forgets what was seen and done."""
        self.following = None
        self.reader.forget()

    def needs_picture(self, instructions: Sequence[str]) -> bool:
        """Whether somebody will look at a picture in the coming step; another instruction makes them look."""
        following = self.following
        return following is None or following.instructions != list(instructions) or len(following.looks) > 0

    @contextmanager
    def undone(self) -> Iterator[None]:
        """What is done inside leaves no trace."""
        before = self.following
        try:
            self.following = None if before is None else before.copy()
            yield
        finally:
            self.following = before

    def loss(self, batch: dict[str, Any]) -> tuple[Tensor, dict[str, float]]:
        """(B,) how wrong the places and the floor are that the network sees, and figures to watch."""
        views, states = read_observation(batch, self.cameras, self.config.image_size)
        pictures, state, texts = views[:, -1, 0], states[:, -1], read_instructions(batch, len(states))
        known, named, floor = self._known(batch), self._texts(batch, LANDMARKS), self._texts(batch, FLOOR)
        landmarks = None if named is None else read_landmarks(named, SPOTS_A_PICTURE)
        patches = None if floor is None else read_patches(floor)
        if self.network.training:
            chosen = torch.rand(len(state)) < self.config.mirror_share
            here = chosen.to(state.device)
            pictures, state = mirror.mirrored_pictures(pictures, here), mirror.STATE.where(here, state)
            places, turned = mirror.PLACES.where(here, known["places"]), known["object"].clone()
            turned[:, 3:9] = mirror.ROTATION_6D.where(here, turned[:, 3:9])
            known, texts = known | {"places": places, "object": turned}, mirror.mirrored_texts(texts, chosen)
            landmarks = None if landmarks is None else mirror.mirrored_landmarks(landmarks, chosen)
            patches = None if patches is None else (mirror.mirrored_floor(patches[0], chosen), patches[1])
            pictures = mirror.recoloured(pictures) if self.config.recolour else pictures
        words, is_word = self.reader.read(texts)
        return self.network.loss(pictures, state, words, is_word, known, landmarks, patches)

    def act(self, batch: dict[str, Any]) -> Tensor:
        """(N, 28) servo targets in rad; a control step passes."""
        pictures, states = read_observation(batch, self.cameras, self.config.image_size)
        state = states[:, -1].cpu()
        instructions = read_instructions(batch, len(state))
        if self.following is None or len(self.following.instructions) != len(instructions):
            self.following = Following.begin(self.network, instructions, BeliefConfig())
        self.following.hear(instructions)
        words, is_word = self.reader.recall(instructions)
        looks = self.following.looks
        action = self.following.act(self.network, pictures[looks, -1, 0], state, words, is_word)
        return action.to(states.device)

    def _texts(self, batch: dict[str, Any], name: str) -> list[str] | None:
        """A text for each picture of a training batch, if the batch or the dataset has such a column."""
        if PREFIX + name in batch:
            return list(batch[PREFIX + name])
        return self._labels.texts(name, torch.as_tensor(batch["index"])) if self._labels is not None else None

    def _known(self, batch: dict[str, Any]) -> dict[str, Tensor]:
        """The labels of a training batch.

        Raises:
            ValueError: neither the batch nor the dataset has them.
        """
        if all(PREFIX + name in batch for name in LABELS):
            return {name: batch[PREFIX + name] for name in LABELS}
        if self._labels is None:
            if self._meta is None:
                raise ValueError("dataset: form=belief is trained on a dataset of hv-record; none was given")
            self._labels = LabelTable(self._meta)
        if "index" not in batch:
            raise ValueError("index: missing from the batch; form=belief looks its labels up by it")
        return self._labels(torch.as_tensor(batch["index"]))
