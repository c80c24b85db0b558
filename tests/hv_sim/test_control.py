import numpy as np

from hv_sim.control import INTENT_HIGH, INTENT_LOW, INTENT_NAMES, NUM_INTENTS


def test_intents_are_fourteen_distinct_names_with_a_range_each():
    assert NUM_INTENTS == len(set(INTENT_NAMES)) == 14
    assert INTENT_LOW.shape == INTENT_HIGH.shape == (14,)
    assert (INTENT_LOW < INTENT_HIGH).all()


def test_the_hands_mirror_each_other():
    low, high = dict(zip(INTENT_NAMES, INTENT_LOW, strict=True)), dict(zip(INTENT_NAMES, INTENT_HIGH, strict=True))
    for axis, flips in (("x", False), ("y", True), ("z", False)):
        left = (low[f"left_hand_{axis}"], high[f"left_hand_{axis}"])
        right = (low[f"right_hand_{axis}"], high[f"right_hand_{axis}"])
        np.testing.assert_allclose(left, (-right[1], -right[0]) if flips else right)


def test_a_robot_that_stands_still_is_within_the_range():
    still = dict.fromkeys(INTENT_NAMES, 0.0) | {"pelvis_height": 0.867, "left_hand_z": 0.8, "right_hand_z": 0.8}
    values = np.array([still[name] for name in INTENT_NAMES])
    assert ((values >= INTENT_LOW) & (values <= INTENT_HIGH)).all()
