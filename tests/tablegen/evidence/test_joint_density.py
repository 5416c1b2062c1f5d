"""The picture of the joint density: the density is one, in one window, and a wrong one shows."""

import numpy as np
import pytest
from tablegen.evidence.joint_density import (
    Source,
    joint_density,
    joint_picture,
    window,
)


@pytest.fixture(scope="module")
def state():
    """Independent u, uniform from -0.5 to 0.5, and v with the density 2 v."""
    state = np.zeros((200_000, 6))
    generator = np.random.default_rng(1)
    state[:, 0] = generator.uniform(-0.5, 0.5, 200_000)
    state[:, 1] = np.sqrt(generator.uniform(0.0, 1.0, 200_000))
    return state


def test_window_holds_the_states_in_square_bins(state):
    u, v = window(state)
    steps = np.concatenate([np.diff(u), np.diff(v)])
    np.testing.assert_allclose(steps, steps[0])
    assert v[0] == 0.0
    inside = (state[:, 0] >= u[0]) & (state[:, 0] <= u[-1]) & (state[:, 1] <= v[-1])
    assert inside.mean() > 0.998


def test_density_is_that_of_the_sample(state):
    u = np.linspace(-0.5, 0.5, 6)
    v = np.linspace(0.0, 1.0, 6)
    found = joint_density(state, u, v)
    expected = np.broadcast_to(v[1:] + v[:-1], (5, 5))  # mean of 2 v in each bin
    # a bin's count has a relative error of (n p)^-1/2, at most 2.5 %; false alarm below 1e-6
    np.testing.assert_allclose(found, expected, rtol=0.15)
    assert np.sum(found) * 0.2 * 0.2 == pytest.approx(1.0, abs=1e-4)
    # u and v exchanged are told apart
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(joint_density(state, u, v).T, expected, rtol=0.15)


def test_what_lies_outside_is_not_redistributed(state):
    halved = joint_density(state, np.linspace(0.0, 0.5, 6), np.linspace(0.0, 1.0, 6))
    assert halved.sum() * 0.1 * 0.2 == pytest.approx(0.5, abs=0.01)


def picture(*states):
    pytest.importorskip("matplotlib")
    sources = [Source(f"source {k}", states[k]) for k in range(len(states))]
    return joint_picture(sources, "joint.png", "Title", "What it shows.")


def test_picture_is_the_same_each_time_and_shows_differences(state):
    made = picture(state, state)
    assert made.data.startswith(b"\x89PNG")
    assert made.media_type == "image/png"
    assert picture(state, state).data == made.data
    mirrored = state.copy()
    mirrored[:, 1] = 1.0 - mirrored[:, 1]
    assert picture(state, mirrored).data != made.data


def test_a_single_state_is_a_point(state):
    point = np.array([[0.1, 0.5, 0.0, 0.0, 0.0, 0.0]])
    moved = point + np.array([0.2, 0, 0, 0, 0, 0])
    assert picture(state, point).data != picture(state, moved).data
