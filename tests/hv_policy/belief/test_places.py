import torch

from hv_policy.belief.places import (
    GROUPS,
    PLACES_DIM,
    from_frame,
    squash,
    squash_waypoint,
    stretch,
    to_frame,
    unsquash,
    unsquash_waypoint,
)


def some_places(num: int = 6) -> torch.Tensor:
    return torch.randn(num, PLACES_DIM, generator=torch.Generator().manual_seed(0)) * 2


def test_groups_hold_every_number_once():
    numbers = [i for group in GROUPS for i in range(PLACES_DIM)[group]]
    assert sorted(numbers) == list(range(PLACES_DIM))


def test_squashing_can_be_undone_and_its_stretch_is_the_derivative():
    places = some_places().double()
    torch.testing.assert_close(unsquash(squash(places)), places, atol=1e-5, rtol=1e-5)
    step = 1e-4
    slope = (unsquash(squash(places) + step) - unsquash(squash(places) - step)) / (2 * step)
    torch.testing.assert_close(stretch(places), slope, atol=1e-4, rtol=1e-4)
    xy = places[:, :2]
    torch.testing.assert_close(unsquash_waypoint(squash_waypoint(xy)), xy, atol=1e-5, rtol=1e-5)


def test_a_frame_turns_points_and_directions_and_shifts_points_alone():
    pose = torch.tensor([[1.0, 2.0, torch.pi / 2]])
    places = torch.zeros(1, PLACES_DIM)
    places[0, 0:3] = torch.tensor([3.0, 0.0, 0.5])  # object ahead
    places[0, 6:9] = torch.tensor([0.0, 0.2, 0.1])  # hands to the left and right
    places[0, 14] = 1.0  # a stand that faces ahead
    moved = to_frame(places, pose)[0]
    torch.testing.assert_close(moved[0:3], torch.tensor([1.0, 5.0, 0.5]))
    torch.testing.assert_close(moved[6:9], torch.tensor([-0.2, 0.0, 0.1]), atol=1e-6, rtol=0)
    torch.testing.assert_close(moved[14:16], torch.tensor([0.0, 1.0]), atol=1e-6, rtol=0)


def test_frames_can_be_undone():
    places = some_places()
    pose = torch.randn(6, 3, generator=torch.Generator().manual_seed(1))
    torch.testing.assert_close(from_frame(to_frame(places, pose), pose), places, atol=1e-5, rtol=1e-5)
