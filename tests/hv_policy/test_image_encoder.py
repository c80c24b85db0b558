import pytest
import torch

from hv_policy.image_encoder import ImageEncoder


@pytest.mark.parametrize("size", [64, 128, 224])
def test_one_token_for_every_sixteen_pixels(size: int):
    encoder = ImageEncoder(size, (16, 32, 64), 1, 48)
    assert encoder(torch.rand(2, 3, size, size)).shape == (2, (size // 16) ** 2, 48)


def test_pictures_of_another_size_are_resized():
    torch.manual_seed(0)
    encoder = ImageEncoder(64, (16, 32, 64), 1, 48).eval()
    small = torch.nn.functional.interpolate(torch.rand(1, 3, 8, 8), size=64, mode="bilinear")
    large = torch.nn.functional.interpolate(small, size=(128, 160), mode="bilinear")
    difference = (encoder(small) - encoder(large)).abs().mean()
    assert difference < 0.2 * (encoder(small) - encoder(torch.rand(1, 3, 64, 64))).abs().mean()


def test_features_do_not_depend_on_the_company():
    torch.manual_seed(0)
    encoder = ImageEncoder(64, (16, 32, 64), 1, 48)  # in training mode, where batch statistics would show
    pictures = torch.rand(5, 3, 64, 64)
    torch.testing.assert_close(encoder(pictures)[2:3], encoder(pictures[2:3]), atol=1e-5, rtol=1e-5)


def test_tokens_tell_where_something_is():
    torch.manual_seed(0)
    encoder = ImageEncoder(64, (16, 32, 64), 1, 48).eval()
    empty = 0.3 * torch.rand(1, 3, 64, 64)

    def centre_of_change(row: int, column: int) -> list[float]:
        """Mean row and column, in tokens, of what a bright spot of 12 px changes."""
        spot = empty.clone()
        spot[..., row : row + 12, column : column + 12] = 1
        with torch.no_grad():
            change = (encoder(spot) - encoder(empty)).norm(dim=-1).reshape(4, 4)
        places = torch.arange(4.0)
        return [float((change.sum(axis) * places).sum() / change.sum()) for axis in (1, 0)]

    top_right, bottom_left = centre_of_change(2, 50), centre_of_change(50, 2)
    assert bottom_left[0] - top_right[0] > 0.5
    assert top_right[1] - bottom_left[1] > 0.5
