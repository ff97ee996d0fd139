"""What adapters claim of orders is something that a run can be held to."""

import pytest

from refdem.core import discovery


@pytest.mark.parametrize("name", discovery.names("engines"))
def test_a_claimed_order_is_at_least_one_and_no_feature_raises_it(name):
    engine = discovery.engine(name)
    stepped = [method for method in engine.methods if method.control == "step"]
    for method in stepped:
        assert method.order >= 1, method.name
        assert all(1 <= order <= method.order for order in method.order_with.values()), method.name
