"""The draw from the spin law: particles that arrive spinning, each with a grain of its own.

The steps are in `sampler.drawing.spin_steps`. A block of draws goes through them side by side, and
what a step reads at scattered places has been prefetched by the step before; a draw alone is a
block of one. Its cost is bounded: one path down a tree, the weights of one leaf's groups and of one
group's experts, one expert.

Word 0 of the keys chooses the group, word 1 the expert, words 2 to 7 are the normals; a grain has
words of its own (see `sampler.drawing.grain`).
"""

import math

import numpy as np
from numba import types

from sampler.compilation.jit import no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.block import BLOCK, item, word_filler
from sampler.drawing.condition_status import condition_status
from sampler.drawing.grain import (
    SIMULATION_KEY,
    aspect_ratio,
    middle_aspect_ratio,
    pick_row,
)
from sampler.drawing.intrinsics import local_array, prefetch
from sampler.drawing.normal import MIDDLE, normal_of_word
from sampler.drawing.philox import uniform
from sampler.drawing.row_counts import NO_ROWS, counted, extrapolates
from sampler.drawing.spin_steps import (
    choose_group,
    choose_of_group,
    effective_factor,
    fill_conditions,
    fill_features,
    fill_scores,
    fill_state,
    find_leaf,
    outcome_at,
    place_among_knots,
)
from sampler.drawing.spin_view import spin_law_of
from sampler.errors import CLAMPED, GRAIN_NOT_KNOWN, NO_SPIN_LAW, NOT_FINITE, OK
from sampler.formats.bounds import (
    EXPERT_STRIDE,
    GROUP_SIZE,
    LANES,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_OUTCOMES,
)

#: Words of a draw, and numbers of a condition.
WORDS, CONDITION = 8, 6
#: Numbers of 16 bits in a cache line; coefficients of the groups of a leaf, and of one group.
_LINE = 32
_GROUP_GATES, _GATES = N_FEATURES * N_GROUPS, N_FEATURES * GROUP_SIZE

_local_row = local_array(types.float32, LANES)


@no_refcount_inline_kernel
def spin_status(spin, alpha1, speed, sx, sy, sz):
    """`OK`, `CLAMPED` or the negative code of a condition with a spin times a/V."""
    factor = effective_factor(sx, sy, sz)
    effective = speed * factor
    angle = spin.alpha_low <= alpha1 <= spin.alpha_high
    # true for what is most common, false for NaN
    if angle and speed > 0.0 and spin.speed_low <= effective <= spin.speed_high:
        return OK
    status = condition_status(alpha1, speed)
    if status == OK and spin.n_shapes == 0:
        return NO_SPIN_LAW
    if status == OK and not (math.isfinite(factor) and math.isfinite(effective)):
        return NOT_FINITE
    return CLAMPED if status == OK else status


@no_refcount_inline_kernel
def shape_row(spin, code):
    """Row of a shape among those of the law; the first if it is none of them."""
    found = 0
    for row in range(spin.n_shapes):
        found = row if spin.shape_codes[row] == code else found
    return found


@no_refcount_inline_kernel
def is_known(spin, code, b_over_a, c_over_b):
    """Whether the law has this shape, and the ratios are ratios; nothing unknown is a number."""
    ratios = 0.0 < b_over_a <= 1.0 and 0.0 < c_over_b <= 1.0
    return ratios and spin.shape_codes[shape_row(spin, code)] == code


def leaf_finder(width):
    """Make the function that finds the leaves of as many draws."""

    @no_refcount_inline_kernel
    def find_leaves(spin, alpha1, speed, spins, grains, conditions, factors, turns, leaves):
        """Write conditions, V_e / V, signs and leaves; prefetch what the leaves have."""
        for n in range(width):
            r, at = np.uint64(n), np.uint64(3 * n)
            three = spins[at], spins[at + np.uint64(1)], spins[at + np.uint64(2)]
            condition = (alpha1[r], speed[r], *three)
            factors[r], turns[r] = fill_conditions(spin, *condition, conditions, CONDITION * n)
        for n in range(width):
            r = np.uint64(n)
            row = shape_row(spin, np.int64(grains[np.uint64(3 * n)]))
            leaf = find_leaf(spin, row, conditions, CONDITION * n)
            leaves[r] = leaf
            prefetch(spin.inputs, leaf * (2 * N_INPUTS))
            for line in range(0, _GROUP_GATES, _LINE):
                prefetch(spin.group_gates, leaf * _GROUP_GATES + line)

    return find_leaves


def expert_chooser(width):
    """Make the function that chooses the experts of as many draws."""

    @no_refcount_inline_kernel
    def choose_experts(spin, words, conditions, grains, leaves, features, records):
        """Write features and the record of the expert of each draw."""
        for n in range(width):
            r, at, first = np.uint64(n), np.uint64(3 * n), N_FEATURES * n
            ratios = grains[at + np.uint64(1)], grains[at + np.uint64(2)]
            fill_features(spin, leaves[r], conditions, CONDITION * n, *ratios, features, first)
        for n in range(width):
            r, first = np.uint64(n), N_FEATURES * n
            base = leaves[r] * _GROUP_GATES
            group = choose_group(spin.group_gates, base, features, first, words[r])
            records[r] = leaves[r] * N_GROUPS + group
            for line in range(0, _GATES, _LINE):
                prefetch(spin.gates, records[r] * _GATES + line)
        for n in range(width):
            r, first = np.uint64(n), N_FEATURES * n
            word = words[np.uint64(width + n)]
            expert = choose_of_group(spin.gates, records[r] * _GATES, features, first, word)
            records[r] = records[r] * GROUP_SIZE + expert
            for line in range(0, EXPERT_STRIDE, _LINE):
                prefetch(spin.experts, records[r] * EXPERT_STRIDE + line)

    return choose_experts


def score_filler(width):
    """Make the function that takes step 5 of as many draws."""
    local_normals = local_array(types.float32, N_OUTCOMES * width)

    @no_refcount_inline_kernel
    def fill_all_scores(arrays, law, words, records, features, scores):
        """Write the scores of each draw, eight numbers apart."""
        normals, own = local_normals(), _local_row()
        for number in range(N_OUTCOMES * width):
            word = words[np.uint64(2 * width + number)]
            normals[np.uint64(number)] = normal_of_word(arrays.normals, word)
        experts = law.experts
        for n in range(width):
            for k in range(N_OUTCOMES):
                own[np.uint64(k)] = normals[np.uint64(k * width + n)]
            record = records[np.uint64(n)]
            fill_scores(experts, record, features, N_FEATURES * n, own, scores, LANES * n)

    return fill_all_scores


def outcome_filler(width):
    """Make the function that takes step 6 of as many draws."""
    local_knots = local_array(types.int32, LANES * width)

    @no_refcount_inline_kernel
    def fill_outcomes(spin, leaves, scores):
        """Replace scores by outcomes."""
        knots = local_knots()
        for number in range(LANES * width):
            k = np.uint64(number)
            knots[k], scores[k] = place_among_knots(spin, scores[k])
        for n in range(width):
            first = leaves[np.uint64(n)] * N_OUTCOMES
            for row in range(N_OUTCOMES):
                k = np.uint64(LANES * n + row)
                function = first + row
                entry = function * spin.n_knots + np.int64(knots[k])
                scores[k] = outcome_at(spin, function, entry, scores[k])

    return fill_outcomes


def spin_drawer(width):
    """Make the function that takes all steps of as many draws."""
    local_conditions = local_array(types.float64, CONDITION * width)
    local_reals, local_longs = local_array(types.float64, width), local_array(types.int64, width)
    local_features = local_array(types.float32, N_FEATURES * width)
    local_scores = local_array(types.float32, LANES * width)
    find_leaves, choose_experts = leaf_finder(width), expert_chooser(width)
    fill_all_scores, fill_outcomes = score_filler(width), outcome_filler(width)

    @no_refcount_inline_kernel
    def draw_spinning(arrays, words, alpha1, speed, spins, grains, states):
        """Make states, six numbers a draw, of random words, conditions and grains.

        `spins` and `grains` have three numbers a draw; `words` has word k of draw r at
        ``k * width + r``.
        """
        spin = spin_law_of(arrays)
        conditions, features, scores = local_conditions(), local_features(), local_scores()
        factors, turns = local_reals(), local_reals()
        leaves, records = local_longs(), local_longs()
        find_leaves(spin, alpha1, speed, spins, grains, conditions, factors, turns, leaves)
        choose_experts(spin, words, conditions, grains, leaves, features, records)
        fill_all_scores(arrays, spin, words, records, features, scores)
        fill_outcomes(spin, leaves, scores)
        for n in range(width):
            r = np.uint64(n)
            fill_state(scores, LANES * n, factors[r], turns[r], states, N_OUTCOMES * n)

    return draw_spinning


def grain_filler(width):
    """Make the function that draws the grains of as many particles."""
    local_words = local_array(types.uint32, WORDS * width)
    local_distances = local_array(types.float64, 2 * width)
    fill_words = word_filler(width)

    @no_refcount_inline_kernel
    def draw_grains(law, seed, index, grain_hit, first, count, grains):
        """Write the grains of the keys, first all as if no ratio lay in a tail of its law."""
        words, distances = local_words(), local_distances()
        fill_words(6, np.uint64(seed) ^ SIMULATION_KEY, index, grain_hit, first, count, words)
        for n in range(width):
            at, row = np.uint64(3 * n), pick_row(law, uniform(words[np.uint64(5 * width + n)]))
            grains[at] = np.float64(law.shape_codes[np.uint64(row)])
            for k in range(2):
                ratio, out = middle_aspect_ratio(
                    law.aspect, k, uniform(words[np.uint64(k * width + n)])
                )
                own = law.fixed_ratios[np.uint64(row), np.uint64(k)]
                grains[at + np.uint64(1 + k)] = own if own > 0.0 else ratio
                distances[np.uint64(2 * n + k)] = 0.0 if own > 0.0 else out
        for n in range(width):
            for k in range(2):
                if distances[np.uint64(2 * n + k)] > MIDDLE:
                    u = uniform(words[np.uint64(k * width + n)])
                    grains[np.uint64(3 * n + 1 + k)] = aspect_ratio(law.aspect, k, u)

    @no_refcount_inline_kernel
    def fill_grains(law, given, seed, index, grain_hit, first, count, grains):
        """Write grains: those given, (n, 3), or if there are none those of the keys."""
        if given.shape[0] == 0:
            draw_grains(law, seed, index, grain_hit, first, count, grains)
            return
        for n in range(width):
            k = np.uint64(first + min(n, count - 1) if given.shape[0] > 1 else 0)
            for part in range(3):
                grains[np.uint64(3 * n + part)] = given[k, np.uint64(part)]

    return fill_grains


local_words = local_array(types.uint32, WORDS * BLOCK)
local_reals = local_array(types.float64, BLOCK)
local_vectors = local_array(types.float64, 3 * BLOCK)
local_states = local_array(types.float64, N_OUTCOMES * BLOCK)
fill_words, fill_grains, draw_spinning = word_filler(BLOCK), grain_filler(BLOCK), spin_drawer(BLOCK)

_one_index, _one_hit = local_array(types.uint64, 1), local_array(types.uint32, 1)
_one_real, _one_vector = local_array(types.float64, 1), local_array(types.float64, 3)
_one_word_row = local_array(types.uint32, WORDS)
_fill_one_words, _draw_one = word_filler(1), spin_drawer(1)


@no_refcount_inline_kernel
def draw_with_spin(arrays, alpha1, speed, spin, grain, seed, index, hit, state):
    """Draw one state of a particle that arrives spinning.

    Parameters
    ----------
    arrays : TableArrays
    alpha1, speed : float
    spin : tuple of three float
        Times a/V, wall frame.
    grain : tuple of three float
        Shape code, b/a and c/b.
    seed, index, hit : int
    state : float64 array, shape (6,), written

    Returns
    -------
    int
        Status, as of `sampler.draw`; with a negative one nothing is written.
    """
    law = spin_law_of(arrays)
    status = spin_status(law, alpha1, speed, spin[0], spin[1], spin[2])
    if status < OK:
        return status
    if not is_known(law, grain[0], grain[1], grain[2]):
        return GRAIN_NOT_KNOWN
    indices, hits = _one_index(), _one_hit()
    indices[0], hits[0] = np.uint64(index), np.uint32(hit)
    angles, speeds, spins, grains = _one_real(), _one_real(), _one_vector(), _one_vector()
    angles[0], speeds[0] = alpha1, speed
    spins[0], spins[1], spins[2] = spin
    words = _one_word_row()
    _fill_one_words(6, seed, indices, hits, 0, 1, words)
    grains[0], grains[1], grains[2] = grain
    _draw_one(arrays, words, angles, speeds, spins, grains, state)
    return status


@no_refcount_kernel
def spin_draw_batch(
    arrays, alpha1, speed, spin, given, grain_hit, seed, index, hit, states, start, stop
):
    """Draw the states of the rows from start to stop; ends with the block of the first error.

    Parameters
    ----------
    arrays : TableArrays
    alpha1, speed : float64 arrays, shape (n,) or (1,)
    spin : float64 array, shape (n, 3) or (1, 3)
        Times a/V, wall frame.
    given : float64 array, shape (n, 3), (1, 3) or (0, 3)
        Grains, or none: then they are those of `grain_hit`.
    grain_hit : uint32 array, shape (n,) or (1,)
    seed : uint64
    index : uint64 array, shape (n,) or (1,)
    hit : uint32 array, shape (n,) or (1,)
    states : float64 or float32 array, shape (n, n_columns), rows start to stop written
    start, stop : int

    Returns
    -------
    tuple of five int
        As `sampler.drawing.batch.draw_batch`.
    """
    words, drawn = local_words(), local_states()
    angles, speeds, spins, grains = local_reals(), local_reals(), local_vectors(), local_vectors()
    law = spin_law_of(arrays)
    counts = NO_ROWS
    for first in range(start, stop, BLOCK):
        count = min(BLOCK, stop - first)
        for n in range(BLOCK):
            r, k = np.uint64(n), first + min(n, count - 1)
            row = np.uint64(k if spin.shape[0] > 1 else 0)
            angles[r], speeds[r] = item(alpha1, k), item(speed, k)
            sx, sy, sz = spin[row, 0], spin[row, 1], spin[row, 2]
            spins[3 * n], spins[3 * n + 1], spins[3 * n + 2] = sx, sy, sz
            status = spin_status(law, angles[r], speeds[r], sx, sy, sz)
            if status < OK:
                return k, status, *counts
            if n < count:
                counts = counted(counts, k, status, extrapolates(arrays, speeds[r]))
        fill_words(6, seed, index, hit, first, count, words)
        fill_grains(law.grains, given, seed, index, grain_hit, first, count, grains)
        draw_spinning(arrays, words, angles, speeds, spins, grains, drawn)
        for n in range(count):
            for column in range(len(arrays.columns)):
                component = np.uint64(6 * n + arrays.columns[column])
                states[np.uint64(first + n), np.uint64(column)] = drawn[component]
    return -1, OK, *counts
