"""Says an instruction again in words and a shape that perception was trained with.

Perception learns what words mean from rooms that are rendered, which is slow: two words for a thing. What people say is
a matter of text alone, and text is cheap. So a small network (`hv-train-rewording`) marks in a sentence what shall be
moved, where to, and where it is now; what was marked becomes the known words that it is nearest to by its meaning
(`hv_policy.word_features`), and a plain sentence is made of them: "it would be nice to have the grey footstool on the
left-hand end of the couch" becomes "put the gray step stool on the left side of the sofa."
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from itertools import groupby
from pathlib import Path

import torch
from safetensors import safe_open
from torch import Tensor, nn

from hv_policy.network_file import load_network, save_network
from hv_policy.text_encoder import split_words
from hv_policy.word_features import FEATURE_DIM, WordFeatures, load_word_features

SHIPPED_REWORDING = Path(__file__).parent / "weights" / "rewording.safetensors"
_KIND = "hv-rewording-1"

THEMES = ("thing", "goal", "source")
"""What the marked words are about: what shall be moved, where to, where it is now (or shall not be)."""
TAGS = (
    *("", "thing_noun", "thing_color", "thing_size"),
    *(f"{theme}_{part}" for theme in THEMES[1:] for part in ("noun", "color", "size", "relation")),
)
"""What a word may be marked as; "" is any other."""
RELATIONS: dict[str, str] = {
    "on": "on {}",
    "on_left": "on the left side of {}",
    "on_middle": "on the middle of {}",
    "on_right": "on the right side of {}",
    "left_of": "just to the left of {}",
    "right_of": "just to the right of {}",
    "in_front_of": "just in front of {}",
    "front_middle": "just in front of the middle of {}",
    "behind": "just behind {}",
    "back_middle": "just behind the middle of {}",
    "floor": "on the floor",
    "room_middle": "exactly in the middle of the room",
    "your_left": "on your left",
    "your_right": "on your right",
}
"""How each relation is said (`hv_sim.lexicon.PLACE_WORDS`); `{}` is the landmark."""
_NAMES = list(RELATIONS)
MAX_WORDS = 64
_LONGEST_NOUN = 3
_ALIKE = 0.5
"""From this cosine on an adjective means the same as a known one."""
_CERTAIN = 0.7
"""Where the thing is now is left out where it is less certain that it is said."""
_TABLES = ("things", "landmarks", "colors", "sizes")


@dataclass(frozen=True)
class RewordingConfig:
    """Sizes of `Rewording`, and from which cosine on a word means the same as a known one.

    Attributes:
        frequent: how many words have an embedding of their own.
        dim, heads, layers: of the transformer.
        least_likeness: of a noun; the others are left as they are.
    """

    frequent: int
    dim: int = 128
    heads: int = 4
    layers: int = 2
    least_likeness: float = 0.7


@dataclass(frozen=True)
class Lexicon:
    """Known words, and what they are called by in what perception reads.

    Attributes:
        things, landmarks, colors, sizes: phrase -> the word for it.
        frequent: words that have an embedding of their own in the network.
    """

    things: dict[str, str]
    landmarks: dict[str, str]
    colors: dict[str, str]
    sizes: dict[str, str]
    frequent: tuple[str, ...] = ()


class Rewording(nn.Module):
    """Marks words: features (S, W, FEATURE_DIM), numbers of frequent words (S, W) and (S, W) bool what is a word ->
    logits of `TAGS` (S, W, 12) and of `RELATIONS` (S, W, 14).

    Args:
        config: sizes.
        lexicon: the words that it knows. Without any, nothing is reworded.
    """

    def __init__(self, config: RewordingConfig, lexicon: Lexicon | None = None) -> None:
        super().__init__()
        self.config, self.lexicon = config, lexicon
        self._number = {word: 1 + i for i, word in enumerate(() if lexicon is None else lexicon.frequent)}
        self.frequent = nn.Embedding(1 + config.frequent, config.dim, padding_idx=0)
        self.meaning = nn.Linear(FEATURE_DIM, config.dim)
        self.position = nn.Parameter(torch.randn(MAX_WORDS, config.dim) * 0.05)
        layer = nn.TransformerEncoderLayer(
            config.dim, config.heads, 2 * config.dim, 0.1, "gelu", batch_first=True, norm_first=True
        )
        self.transformer = nn.TransformerEncoder(layer, config.layers, enable_nested_tensor=False)
        self.tag = nn.Linear(config.dim, len(TAGS))
        self.relation = nn.Linear(config.dim, len(RELATIONS))
        for name in _TABLES:
            known = {} if lexicon is None else getattr(lexicon, name)
            self.register_buffer(f"{name}_meaning", torch.zeros(len(known), FEATURE_DIM))

    def forward(self, features: Tensor, numbers: Tensor, is_word: Tensor) -> tuple[Tensor, Tensor]:
        tokens = self.meaning(features) + self.frequent(numbers) + self.position[: features.shape[1]]
        tokens = self.transformer(tokens, src_key_padding_mask=~is_word)
        return self.tag(tokens), self.relation(tokens)

    def look_up(self, features: WordFeatures) -> None:
        """What the words of the lexicon mean; it stays with the weights."""
        for name in _TABLES:
            phrases = [split_words(phrase) for phrase in getattr(self.lexicon, name)]
            getattr(self, f"{name}_meaning").copy_(torch.stack([_phrase_meaning(features, words) for words in phrases]))

    def known(self, name: str) -> Tensor:
        """(K, FEATURE_DIM) what the words of a table of the lexicon mean, each of length 1."""
        return nn.functional.normalize(getattr(self, f"{name}_meaning").float(), dim=-1)

    def number(self, words: Sequence[str]) -> list[int]:
        """Of frequent words from 1 on, 0 for all others."""
        return [self._number.get(word, 0) for word in words]


@dataclass
class Marked:
    """A text of W words."""

    words: list[str]
    tags: list[str]  # of `TAGS`
    certain: Tensor  # (W,) how likely each tag is
    relations: Tensor  # (W, 14) logarithm of how likely each relation is for a word

    def picked(self, wanted: str) -> list[str]:
        """The words in a row with a tag, hyphens between them among them; of several rows the most certain one, or the
        first where that does not tell."""
        tags = ["", *self.tags, ""]
        found = [
            tag == wanted or (tags[i] == tags[i + 2] == wanted and self.words[i] == "-")
            for i, tag in enumerate(self.tags)
        ]
        rows = [[i for i, _ in group] for has_tag, group in groupby(enumerate(found), lambda f: f[1]) if has_tag]
        best = max(rows, key=lambda row: round(float(self.certain[row].mean()), 1), default=[])
        return [self.words[i] for i in best]


class Reworder:
    """Rewords instructions, each one only once.

    Args:
        network: marks the words.
        features: what words mean.
    """

    def __init__(self, network: Rewording, features: WordFeatures | None = None) -> None:
        assert network.lexicon is not None
        self.network, self.lexicon = network, network.lexicon
        self.features = load_word_features() if features is None else features
        self.say = lru_cache(maxsize=4096)(self._say)
        self.goal = lru_cache(maxsize=4096)(self._goal)

    @torch.no_grad()
    def marked(self, text: str) -> Marked:
        """The words of a text, and what each is about."""
        words = split_words(text)[:MAX_WORDS]
        if not words:
            return Marked([], [], torch.zeros(0), torch.zeros(0, len(RELATIONS)))
        device = self.network.position.device
        features = self.features.of(words)[None].float().to(device)
        numbers = torch.tensor([self.network.number(words)], device=device)
        self.network.eval()  # also while the student trains
        tags, relations = self.network(features, numbers, torch.ones_like(numbers, dtype=torch.bool))
        certain, best = tags[0].softmax(-1).cpu().max(-1)
        marked = Marked(words, [TAGS[i] for i in best.tolist()], certain, relations[0].log_softmax(-1).cpu())
        for theme in THEMES:
            self._widen(marked, f"{theme}_noun", [self.lexicon.things, self.lexicon.landmarks])
        return marked

    def _widen(self, marked: Marked, tag: str, tables: Sequence[dict[str, str]]) -> None:
        """Takes the words before a noun into it as long as they make a longer known one: "side" of "side table"."""
        words = marked.words
        at = [i for i, found in enumerate(marked.tags) if found == tag]
        for first in range(max(0, at[0] - _LONGEST_NOUN) if at else 0, at[0] if at else 0):
            if any(" ".join(words[first : at[-1] + 1]) in table for table in tables):
                marked.tags[first : at[-1] + 1] = [tag] * (at[-1] + 1 - first)
                return

    def _goal(self, text: str) -> tuple[str, str]:
        """Where something shall go: one of `RELATIONS`, and the known word for the piece of furniture that it refers
        to; "" for either where there is none, and for what refers to another thing."""
        marked = self.marked(text)
        noun = self._phrase(marked, "goal", adjectives=False)
        relation, _ = self._relation(marked, "goal", bool(noun))
        return relation, "" if noun in self.lexicon.things.values() else noun

    def _say(self, text: str) -> str:
        """The instruction in known words, or as it is where no thing and no goal are found in it."""
        marked = self.marked(text)
        thing, goal = self._phrase(marked, "thing"), self._place(marked, "goal", 0.0)
        if not thing or not goal:
            return text
        source = self._place(marked, "source", _CERTAIN)
        if source.startswith("on your"):
            return f"put the {thing} that is {source} {goal}."
        if source and source != goal:
            return f"take the {thing} that is {source} and put it {goal}."
        return f"put the {thing} {goal}."

    def _phrase(self, marked: Marked, theme: str, adjectives: bool = True) -> str:
        """Adjectives and noun of a theme, in known words; "" without a noun."""
        noun = marked.picked(f"{theme}_noun")
        if not noun:
            return ""
        tables = ["things"] if theme == "thing" else ["landmarks", "things"]
        known = self._noun(noun, tables, self.network.config.least_likeness)
        if not adjectives:
            return known
        size, color = (self._adjective(marked.picked(f"{theme}_{part}"), f"{part}s") for part in ("size", "color"))
        return " ".join(part for part in (size, color, known) if part)

    def _relation(self, marked: Marked, theme: str, has_landmark: bool) -> tuple[str, float]:
        """The likeliest of the `RELATIONS` that have a landmark, or of those that have none, and how likely it is;
        "" where none is said."""
        said = [i for i, tag in enumerate(marked.tags) if tag == f"{theme}_relation"]
        if not said:
            return "", 0.0
        likely = marked.relations[said].mean(0)
        fits = torch.tensor([("{}" in phrase) == has_landmark for phrase in RELATIONS.values()])
        best = int(likely.masked_fill(~fits, -1e9).argmax())
        return _NAMES[best], min(float(likely[best].exp()), float(marked.certain[said].mean()))

    def _place(self, marked: Marked, theme: str, certain: float) -> str:
        """A place in known words; "" where there is none, or it is less `certain` what it is."""
        landmark = self._phrase(marked, theme)
        relation, likely = self._relation(marked, theme, bool(landmark))
        return RELATIONS[relation].format(f"the {landmark}") if relation and likely >= certain else ""

    def _adjective(self, words: Sequence[str], table: str) -> str:
        """The known adjective for some words: the longest one among them ("steel green" is green), or the nearest, if
        one is near."""
        said, known = f" {' '.join(words)} ".replace(" - ", "-"), getattr(self.lexicon, table)
        among = [phrase for phrase in known if f" {phrase} " in said or f" {phrase} " in said.replace("-", " ")]
        if among:
            return known[max(among, key=len)]
        nearest = self._noun(words, [table], _ALIKE)
        return nearest if nearest in known.values() else ""

    def _noun(self, words: Sequence[str], tables: Sequence[str], least: float) -> str:
        """The known word for a phrase; the phrase itself where nothing in the tables is as near as `least`."""
        phrase = " ".join(words).replace(" - ", "-")
        called = [getattr(self.lexicon, name) for name in tables]
        exact = [table[phrase] for table in called if phrase in table]
        if not words or exact:
            return exact[0] if exact else ""
        meaning = _phrase_meaning(self.features, words)
        likeness = torch.cat([self.network.known(name).to(meaning.device) for name in tables]) @ meaning
        best = int(likeness.argmax())
        return [word for table in called for word in table.values()][best] if float(likeness[best]) >= least else phrase


def _phrase_meaning(features: WordFeatures, words: Sequence[str]) -> Tensor:
    """(FEATURE_DIM,) what a noun phrase means, of length 1: the mean of its words' features, read behind "the"."""
    return nn.functional.normalize(features.of(["the", *words])[1:].float().mean(0), dim=0)


def save_rewording(network: Rewording, path: Path = SHIPPED_REWORDING) -> None:
    """Writes weights (half precision) and words."""
    assert network.lexicon is not None
    lexicon = {field.name: getattr(network.lexicon, field.name) for field in fields(Lexicon)}
    save_network(network.half(), network.config, path, _KIND, {"lexicon": json.dumps(lexicon)})


def load_rewording(path: Path = SHIPPED_REWORDING) -> Rewording:
    """The frozen network of a file of `save_rewording`.

    Raises:
        ValueError: the file is not one.
    """
    def build(config: RewordingConfig) -> Rewording:
        return Rewording(config, _lexicon(path))

    network = load_network(path, _KIND, lambda values: RewordingConfig(**values), build)
    return network.float().requires_grad_(False)


def _lexicon(path: Path) -> Lexicon:
    with safe_open(str(path), framework="pt") as file:
        found = json.loads((file.metadata() or {})["lexicon"])
    return Lexicon(**{**found, "frequent": tuple(found["frequent"])})
