"""Operations that answer a row alone as in company: against PyTorch's own, and by bits."""

import torch
from torch import nn

from hv_policy.batch_invariant import BatchInvariantLinear, atan2


def test_a_row_is_the_same_in_any_company():
    torch.manual_seed(0)
    layer = BatchInvariantLinear(300, 70).eval()
    rows = torch.randn(41, 300)
    with torch.no_grad():
        together = layer(rows)
        for first, count in ((0, 1), (3, 2), (7, 19), (40, 1)):
            assert torch.equal(layer(rows[first : first + count]), together[first : first + count])


def test_it_is_a_linear_layer_and_learns_as_one():
    torch.manual_seed(0)
    layer, plain = BatchInvariantLinear(20, 5), nn.Linear(20, 5)
    plain.load_state_dict(layer.state_dict())
    rows = torch.randn(8, 20)
    assert torch.equal(layer(rows), plain(rows)), "with gradients it is the same product"
    with torch.no_grad():
        torch.testing.assert_close(layer.eval()(rows), plain(rows))
    for one in (layer, plain):
        one(rows).square().sum().backward()
    assert torch.equal(layer.weight.grad, plain.weight.grad)


def test_an_angle_is_the_same_in_any_company():
    torch.manual_seed(0)
    y, x = torch.randn(2, 301, 2)
    together = atan2(y, x)
    torch.testing.assert_close(together, torch.atan2(y, x), atol=1e-6, rtol=0)
    assert torch.equal(torch.cat([atan2(y[i : i + 1], x[i : i + 1]) for i in range(len(y))]), together)
    assert torch.equal(atan2(y.mT, x.mT).mT, together), "nor does it matter how they lie in memory"
    assert atan2(y.double(), x[:1].double()).dtype == torch.float64
