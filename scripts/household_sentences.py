"""Sentences that somebody might say to a household robot, of all kinds: what text features are distilled on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

THINGS = """
box|carton|parcel|package|crate|slatted crate|basket|hamper|laundry basket|bin|trash can|waste basket|garbage pail
bucket|tub|tray|bowl|pot|cooking pot|pan|saucepan|casserole|kettle|teapot|jug|pitcher|mug|cup|glass|bottle|jar|can|tin
canister|plate|dish|cutlery|drawer|toaster|microwave|oven|blender|mixer|juicer|coffee maker|coffee machine
espresso machine|rice cooker|slow cooker|bread bin|bread box|fruit bowl|bowl of fruit|vase|urn|plant|houseplant|cactus
fern|flower|flower pot|planter|lamp|table lamp|desk lamp|reading lamp|floor lamp|standard lamp|lantern|candle
candlestick|torch|globe|clock|alarm clock|mantel clock|radio|stereo|speaker|loudspeaker|television|TV|TV set|monitor
computer|computer screen|laptop|notebook|tablet|printer|scanner|keyboard|projector|camera|phone|telephone|fan|heater
humidifier|vacuum cleaner|iron|cushion|pillow|bolster|blanket|pile of blankets|quilt|duvet|towel|book|stack of books
pile of magazines|newspaper|folder|binder|teddy bear|soft toy|stuffed animal|doll|toy|ball|game|puzzle|guitar|suitcase
trunk|backpack|rucksack|school bag|bag|handbag|briefcase|duffel bag|gym bag|satchel|toolbox|tool case|hammer|drill
paint can|jerry can|fuel can|fire extinguisher|cable reel|spool|rope|hose|barrel|drum|keg|cask|cooler|ice chest|chest
treasure chest|storage box|tote|stool|footstool|step stool|bar stool|chair|dining chair|folding chair|rocking chair
high chair|armchair|easy chair|pouf|ottoman|hassock|beanbag|side table|end table|nightstand|bedside table|coffee table
picture frame|mirror|umbrella stand|gift|present|ornament|sculpture
""".replace("\n", "|").strip("|").split("|")
FURNITURE = """
table|desk|writing desk|dining table|kitchen table|coffee table|cocktail table|console table|hall table|sofa|couch
settee|love seat|armchair|recliner|bench|window seat|bed|double bed|single bed|bunk bed|crib|wardrobe|closet|armoire
dresser|chest of drawers|bureau|vanity|dressing table|nightstand|bedside table|bookcase|bookshelf|shelf|shelves
shelving unit|cabinet|cupboard|display case|glass cabinet|sideboard|buffet|credenza|TV stand|media console|counter
countertop|worktop|kitchen island|breakfast bar|sink|kitchen sink|stove|cooker|range|oven|fridge|refrigerator|freezer
dishwasher|washing machine|washer|dryer|pantry|larder|trolley|cart|serving cart|rack|pallet rack|clothes rack|shoe rack
coat stand|hat stand|workbench|work table|packing table|conveyor|conveyor belt|forklift|pallet|skid|stack of pallets
locker|tool cabinet|ladder|stepladder|traffic cone|fireplace|hearth|mantelpiece|piano|upright piano|rug|carpet|mat
curtain|window|door|doorway|wall|corner|radiator|mirror|standing mirror|floor lamp|potted tree|indoor tree|fish tank
record player|stereo|aquarium|staircase|stairs|hallway|bathtub|shower|toilet|basin|barrel|crate
""".replace("\n", "|").strip("|").split("|")
ADJECTIVES = """
red|orange|yellow|green|teal|turquoise|blue|light blue|dark blue|navy|purple|violet|pink|brown|light brown
dark brown|tan|beige|cream|white|off-white|silver|gray|grey|dark gray|charcoal|black|terracotta|brick-red|golden
oak|pale wood
walnut|wooden|metal|steel|plastic|glass|leather|woven|wicker|cardboard|ceramic|striped|plain|round|square|tall|short
low|high|small|little|tiny|large|big|huge|medium-sized|heavy|light|empty|full|old|new|open|closed|upholstered
folding|potted
electric|tabletop|antique|modern|soft|wrapped
""".replace("\n", "|").strip("|").split("|")
RELATIONS = """
on|on top of|onto|upon|to the left of|left of|on the left of|just to the left of|to the right of|right of
on the right of|directly to the right of|in front of|just in front of|before|behind|at the back of|next to|beside|by
near|close to|under|underneath|below|above|inside|into|between|against|across from|opposite|on the left side of
on the right side of|on the left end of|on the right-hand end of|in the middle of|on the middle of|in the centre of
in the center of|at the edge of|in the corner of|immediately behind|a few inches from|at the foot of|over|along
""".replace("\n", "|").strip("|").split("|")
TRANSFERS = """
move|put|place|set|carry|bring|take|shift|relocate|transfer|transport|deliver|haul|lug|push|slide|lay|stand|position|drop
leave|deposit|park|return|store|stow|rest
""".replace("\n", "|").strip("|").split("|")
PICKS = """
pick up|grab|lift|take|fetch|get|collect|hold|go to|walk to|find|look for|look at|point at|turn to|go over to|put down
""".replace("\n", "|").strip("|").split("|")
OPENINGS = (
    *("", "", "", "", "", "", "please", "now", "next", "then", "okay", "could you", "can you", "would you", "robot,"),
    *("I want you to", "I'd like you to", "you should", "first", "after that", "will you please", "kindly", "let's"),
)
ENDINGS = ("", "", "", "", "please", "now", "for me", "carefully", "and step back", "right away", "thanks")
ROOMS = ("room", "kitchen", "bedroom", "living room", "warehouse", "hall", "floor", "ground", "office", "bathroom")


def household_sentence(rng: np.random.Generator, any_words: Sequence[str] | None = None) -> str:
    """One sentence.

    Args:
        rng: decides everything.
        any_words: half of the things in the sentence are called by one of these instead.
    """
    thing, other, there = (_thing(rng, pool, any_words) for pool in (THINGS, THINGS, FURNITURE))
    transfer, pick, relation = (str(rng.choice(pool)) for pool in (TRANSFERS, PICKS, RELATIONS))
    second, room = str(rng.choice(RELATIONS)), str(rng.choice(ROOMS))
    body = str(
        rng.choice(
            [
                *[f"{transfer} {thing} {relation} {there}"] * 5,
                *[f"{pick} {thing} and {transfer} it {relation} {there}"] * 3,
                f"{transfer} {thing} that is {second} {other} {relation} {there}",
                f"{transfer} {thing}, the one {second} {there}, {relation} {other}",
                f"{transfer} {thing} from {relation} {there} to {second} {other}",
                f"{pick} {thing}",
                f"{pick} {thing} {relation} {there}",
                f"{thing} belongs {relation} {there}",
                f"{thing} goes {relation} {other}",
                f"{thing} should be {relation} {there}, not {second} {other}",
                f"{thing} {relation} {there}",
                f"{thing}",
                f"{there}",
                f"{relation} {there}",
                f"there is {thing} {relation} {there}",
                f"where is {thing}",
                f"{transfer} {thing} in the middle of the {room}",
                f"{transfer} {thing} on the {room}",
                f"{pick} {thing} in the {room} and {transfer} it {relation} {other}",
                f"tidy up: {transfer} {thing} {relation} {there}",
                f"somebody left {thing} {relation} {there}, {transfer} it {second} {other}",
                f"{thing} is in the way, {transfer} it {relation} {there}",
            ]
        )
    )
    words = " ".join(part for part in (str(rng.choice(OPENINGS)), body, str(rng.choice(ENDINGS))) if part)
    return (words[0].upper() + words[1:] if rng.random() < 0.5 else words) + str(rng.choice(["", ".", ".", "!", "?"]))


def _thing(rng: np.random.Generator, pool: Sequence[str], any_words: Sequence[str] | None) -> str:
    noun = str(rng.choice(pool))
    if rng.random() < 0.15 and pool is THINGS:
        noun += " " + str(rng.choice(pool))
    if any_words is not None and rng.random() < 0.5:
        noun = str(any_words[int(rng.integers(len(any_words)))])
    adjectives = [str(rng.choice(ADJECTIVES)) for _ in range(int(rng.choice([0, 0, 1, 1, 2])))]
    if any_words is not None and rng.random() < 0.2:
        adjectives.append(str(any_words[int(rng.integers(len(any_words)))]))
    article = str(rng.choice(["the", "the", "the", "a", "that", "this", "my", "your", ""]))
    return " ".join(part for part in (article, *adjectives, noun) if part)
