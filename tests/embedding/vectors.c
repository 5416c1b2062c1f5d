/* Known-answer vectors through the C header: vectors TABLE.rbt CASES.txt TOLERANCE

   Compiled as C and as C++. A tolerance of 0 asks for the same bits from every draw; rebounds call
   atan2, cos and sin of the C library, and may differ in the last digits. Prints the number of
   cases, or the first case that fails. The lines are those of write_cases in known_vectors.py. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LIBRARY_ROUNDING 1e-13
#define ROUGH_ROUNDING 1e-12
/* a last digit of an angle may turn the last digit of a feature, in single precision */
#define SPIN_ROUNDING 1e-5
/* rows enough for a block */
#define ROWS 17

typedef struct vector_case {
    double given[11], spin[3], inertia, expected[RBT_VALUES], after;
    uint64_t seed, index;
    uint32_t hit;
    int code, draws, rough, spins;
} vector_case;

static int read_reals(FILE *file, int n, double *numbers)
{
    int found = 0;
    while (found < n && fscanf(file, "%lf", numbers + found) == 1)
        found++;
    return found == n;
}

/* The next case; 0 at the end. */
static int read_case(FILE *file, vector_case *c)
{
    long long seed, index;
    if (fscanf(file, "%d %d %d", &c->draws, &c->rough, &c->spins) != 3)
        return 0;
    if (!read_reals(file, 11, c->given) || !read_reals(file, 3, c->spin) ||
        !read_reals(file, 1, &c->inertia) ||
        fscanf(file, "%lld %lld %d %d", &seed, &index, (int *)&c->hit, &c->code) != 4 ||
        !read_reals(file, RBT_VALUES, c->expected) || !read_reals(file, 1, &c->after))
        exit(4);
    c->seed = (uint64_t)seed;
    c->index = (uint64_t)index;
    return 1;
}

/* Whether results are as expected, or NaN where the code is an error. */
static int agree(int code, int n, const double *got, const double *expected, double tolerance)
{
    double size = 1.0;
    for (int k = 0; k < n; k++)
        size = fmax(size, fabs(expected[k]));
    for (int k = 0; k < n; k++) {
        uint64_t bits; /* flags may take isnan away */
        memcpy(&bits, got + k, sizeof bits);
        if (code < 0 ? bits != 0x7ff8000000000000u : !(fabs(got[k] - expected[k]) <= tolerance * size))
            return 0;
    }
    return 1;
}

/* The same numbers for each row. */
static void repeat(size_t width, const double *numbers, double *rows)
{
    for (size_t k = 0; k < ROWS; k++)
        memcpy(rows + width * k, numbers, width * sizeof *numbers);
}

static void repeat_keys(const vector_case *c, uint64_t *index, uint32_t *hit)
{
    for (size_t k = 0; k < ROWS; k++) {
        index[k] = c->index;
        hit[k] = c->hit;
    }
}

/* A row by itself, and many times in one call, which are drawn as a block; `moved` is the same table at
   another address. */
static int check_draw(const rbt_table *table, const rbt_table *moved, const vector_case *c,
                      double tolerance)
{
    uint64_t index[ROWS];
    uint32_t hit[ROWS];
    double alpha1[ROWS], speed[ROWS], spin[3 * ROWS], inertia[ROWS], after[ROWS];
    double states[ROWS * RBT_VALUES], expected[RBT_VALUES];
    int columns[RBT_VALUES], codes[ROWS], only[ROWS], holds = 1;
    rbt_conditions given;
    const int width = rbt_variables(table, columns);
    memset(&given, 0, sizeof given);
    repeat(1, c->given, alpha1);
    repeat(1, c->given + 1, speed);
    repeat(3, c->spin, spin);
    repeat(1, &c->inertia, inertia);
    repeat_keys(c, index, hit);
    given.alpha1 = alpha1;
    given.speed = speed;
    given.spin = c->spins ? spin : NULL;
    given.inertia = inertia;
    given.index = index;
    given.hit = hit;
    given.inertia_after = after;
    for (int k = 0; k < width; k++)
        expected[k] = c->expected[columns[k]];
    for (size_t n = 1; n <= ROWS; n += ROWS - 1) {
        holds = holds && rbt_sample(n == 1 ? moved : table, n, &given, c->seed, states, codes) == c->code;
        holds = holds && rbt_sample(table, n, &given, c->seed, NULL, only) == c->code;
        for (size_t r = 0; r < n; r++)
            holds = holds && codes[r] == c->code && only[r] == c->code &&
                    agree(c->code, width, states + r * (size_t)width, expected, tolerance) &&
                    agree(c->code, 1, after + r, &c->after, tolerance);
    }
    return holds;
}

/* Whether results are what a particle came with. */
static int is_kept(const vector_case *c, const double *velocity, const double *omega, double after)
{
    const size_t vector = 3 * sizeof *omega;
    return memcmp(velocity, c->given, vector) == 0 && memcmp(omega, c->spin, vector) == 0 &&
           memcmp(&after, &c->inertia, sizeof after) == 0;
}

static int check_rebound(const rbt_table *table, const vector_case *c, double least)
{
    const int rough = c->rough, spins = c->spins, kept = c->code == RBT_ERR_NOT_APPROACHING;
    const double rounding = spins ? SPIN_ROUNDING : rough ? ROUGH_ROUNDING : LIBRARY_ROUNDING;
    const double tolerance = fmax(least, rounding);
    double rows[4][3 * ROWS], half_size[ROWS], roughness[ROWS], inertia[ROWS];
    double velocity[3 * ROWS], omega[3 * ROWS], after[ROWS];
    uint64_t index[ROWS];
    uint32_t hit[ROWS];
    int codes[ROWS], holds = 1;
    rbt_impacts impacts;
    rbt_rebounds found;
    memset(&impacts, 0, sizeof impacts);
    memset(&found, 0, sizeof found);
    repeat(3, c->given, rows[0]);
    repeat(3, c->given + 3, rows[1]);
    repeat(3, c->given + 7, rows[2]);
    repeat(3, c->spin, rows[3]);
    repeat(1, c->given + 6, half_size);
    repeat(1, c->given + 10, roughness);
    repeat(1, &c->inertia, inertia);
    repeat_keys(c, index, hit);
    impacts.velocity = rows[0];
    impacts.normal = rows[1];
    impacts.half_size = half_size;
    impacts.wall_velocity = rows[2];
    impacts.omega = spins ? rows[3] : NULL;
    impacts.inertia = spins ? inertia : NULL;
    impacts.roughness = rough ? roughness : NULL;
    impacts.index = index;
    impacts.hit = hit;
    impacts.fresh = !rbt_has_spin_law(table);
    found.velocity = velocity;
    found.omega = omega;
    found.inertia = after;
    found.codes = codes;
    for (size_t n = 1; n <= ROWS; n += ROWS - 1) {
        holds = holds && rbt_rebound(table, n, &impacts, c->seed, &found) == c->code &&
                found.bad == (c->code < 0 ? n : 0) && found.first_bad == (c->code < 0 ? 0 : n);
        for (size_t r = 0; r < n; r++)
            holds = holds && codes[r] == c->code &&
                    (kept ? is_kept(c, velocity + 3 * r, omega + 3 * r, after[r])
                          : agree(c->code, 3, velocity + 3 * r, c->expected, tolerance) &&
                                agree(c->code, 3, omega + 3 * r, c->expected + 3, tolerance) &&
                                (!spins || agree(c->code, 1, after + r, &c->after, tolerance)));
    }
    return holds;
}

int main(int argc, char **argv)
{
    if (argc != 4)
        return 2;
    rbt_table *table;
    const int code = rbt_open(argv[1], &table);
    FILE *file = fopen(argv[2], "r");
    if (code < 0 || !file) {
        fprintf(stderr, "%s: %s\n", argv[1], code < 0 ? rbt_strerror(code) : "no vectors");
        return 1;
    }
    size_t size;
    const void *image = rbt_image(table, &size);
    char *memory = (char *)malloc(size + 64);
    if (!memory)
        return 1;
    char *copy = memory + (64 - (uintptr_t)memory % 64) % 64;
    memcpy(copy, image, size);
    const rbt_table moved = rbt_moved(table, copy);
    const double tolerance = strtod(argv[3], NULL);
    vector_case c;
    int cases = 0, holds = 1;
    while (holds && read_case(file, &c)) {
        holds = c.draws ? check_draw(table, &moved, &c, tolerance)
                        : check_rebound(table, &c, tolerance);
        cases++;
    }
    fclose(file);
    rbt_close(table);
    free(memory);
    printf(holds ? "%d cases\n" : "case %d fails\n", cases);
    return !holds;
}
