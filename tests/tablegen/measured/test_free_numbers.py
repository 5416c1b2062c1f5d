"""Free numbers of each form of the laws, and their places in a pair file."""

import numpy as np
from refusals import refused
from synthetic_measurements import SOURCE, small_pair

from tablegen import load_config
from tablegen.measured.free_numbers import FreeNumbers, chosen_names


def test_forms_of_laws_have_their_free_numbers():
    corundum = load_config("corundum-steel")
    names = chosen_names(corundum, ())
    assert names == (
        "pair.restitution.coefficient",
        "pair.restitution.exponent",
        "pair.resistance.strength",
        "pair.resistance.factor",
    )
    assert chosen_names(corundum, ["+pair.resistance.factor"]) == names
    assert chosen_names(corundum, names[:1]) == names[:1]
    numbers = FreeNumbers(corundum, names)
    np.testing.assert_allclose(numbers.numbers(numbers.start), [0.1, 0.61, 1.0, 1.0])
    assert numbers.pair(numbers.start) == corundum.pair
    refused("free", chosen_names, corundum, names[:1] * 2)


def test_polynomials_stay_restitutions_and_friction_keeps_its_order():
    law = {"law": "polynomial", "coefficients": [0.9, -0.5, 0.1], **SOURCE}
    numbers = FreeNumbers(small_pair(pair={"restitution": law}), ["pair.restitution.coefficients"])
    np.testing.assert_allclose(numbers.numbers(numbers.start), [0.9, -0.5, 0.1], atol=1e-12)
    for x in np.random.default_rng(1).integers(0, 2, (8, 3)).astype(float):
        numbers.pair(x)  # raises if the law leaves [0, 1]
    law = {"law": "coulomb", "static": 0.4, "dynamic": 0.3, **SOURCE}
    names = ["pair.resistance.static", "pair.resistance.dynamic"]
    numbers = FreeNumbers(small_pair(pair={"resistance": law}), names)
    assert numbers.pair(np.array([0.2, 0.5])).resistance.static == 0.5
