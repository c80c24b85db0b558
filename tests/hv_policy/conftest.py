import pytest
from policy_samples import make_policy

from hv_policy.modeling_hv import HVPolicy


@pytest.fixture(scope="session")
def trained_like_policy() -> HVPolicy:
    """A policy in evaluation mode whose outputs depend on everything that they should depend on."""
    return make_policy().eval()
