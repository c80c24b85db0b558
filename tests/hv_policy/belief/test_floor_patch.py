import numpy as np
import pytest
import torch

from hv_policy.belief.floor_patch import NO_PATCH, patch_points, read_patches, write_patch


def test_patches_come_back_and_none_is_told_apart():
    rng = np.random.default_rng(0)
    patches = rng.random((2, len(patch_points()))) < 0.3
    taken, known = read_patches([write_patch(patches[0]), NO_PATCH, write_patch(patches[1])])
    assert known.tolist() == [True, False, True]
    np.testing.assert_array_equal(taken[[0, 2]].numpy(), patches)


def test_points_are_the_middles_of_cells_ahead_first():
    points = patch_points().view(64, 64, 2)
    torch.testing.assert_close(points[0, 0], torch.tensor([-1.9375, -3.9375]))
    torch.testing.assert_close(points[63, 1], torch.tensor([5.9375, -3.8125]))


@pytest.mark.parametrize("text", ["no patch", "AAAA", "eJwD"])
def test_what_is_no_patch_is_refused_in_one_line(text):
    with pytest.raises(ValueError, match="is no patch of 64 x 64 cells") as error:
        read_patches([text])
    assert "\n" not in str(error.value)
