/* Known-answer vectors through the C header: vectors TABLE.rbt VECTORS.txt TOLERANCE

   Compiled as C and as C++. A tolerance of 0 asks for the same bits from every draw; rebounds call
   atan2, cos and sin of the C library, and may differ in the last digits. Prints the number of
   cases, or the first case that fails. The lines are those of tests/vectors/make_vectors.py. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <stdio.h>

#define UNTOUCHED 12345.0
#define LIBRARY_ROUNDING 1e-13
#define ROUGH_ROUNDING 1e-12
/* a last digit of an angle may turn the last digit of a feature, in single precision */
#define SPIN_ROUNDING 1e-5

typedef struct vector_case {
    double given[14], expected[RBT_VALUES];
    uint64_t seed, index;
    uint32_t hit;
    int code, draws, rough, spins;
} vector_case;

static int read_case(char *text, vector_case *c)
{
    static const struct {
        const char *word;
        int draws, rough, spins;
    } kinds[] = {{"draw", 1, 0, 0},      {"rebound", 0, 0, 0},      {"rough-rebound", 0, 1, 0},
                 {"spin-draw", 1, 0, 1}, {"spin-rebound", 0, 0, 1}, {"spin-rough", 0, 1, 1}};
    char *end = strchr(text, ' ');
    size_t kind = 0;
    memset(c, 0, sizeof *c);
    if (end == NULL)
        return 0;
    *end = 0;
    while (kind < 6 && strcmp(text, kinds[kind].word) != 0)
        kind++;
    if (kind == 6)
        return 0;
    c->draws = kinds[kind].draws;
    c->rough = kinds[kind].rough;
    c->spins = kinds[kind].spins;
    const int n = (c->draws ? 2 : 10) + c->rough + 3 * c->spins;
    text = end + 1;
    for (int k = 0; k < n; k++)
        c->given[k] = strtod(text, &text);
    c->seed = strtoull(text, &text, 10);
    c->index = strtoull(text, &text, 10);
    c->hit = (uint32_t)strtoull(text, &text, 10);
    c->code = (int)strtol(text, &text, 10);
    /* a table without the work of the impulses has 0 for it, and no numbers in the line */
    for (int k = 0; k < RBT_VALUES && *text == ' '; k++)
        c->expected[k] = strtod(text, &text);
    return *text == '\n';
}

/* Whether results are as expected, or untouched where the code is an error. */
static int agree(int code, int n, const double *got, const double *expected, double tolerance)
{
    double size = 1.0;
    for (int k = 0; k < n; k++)
        size = fmax(size, fabs(expected[k]));
    for (int k = 0; k < n; k++) {
        const double wanted = code < 0 ? UNTOUCHED : expected[k];
        if (!(fabs(got[k] - wanted) <= tolerance * size))
            return 0;
    }
    return 1;
}

static void set_untouched(int n, double *values)
{
    for (int k = 0; k < n; k++)
        values[k] = UNTOUCHED;
}

/* Columns of the table, in both precisions, by rbt_sample_batch. */
static int check_columns(const rbt_table *table, const vector_case *c, double tolerance)
{
    double states[RBT_VALUES], expected[RBT_VALUES], rounded[RBT_VALUES], found[RBT_VALUES];
    float singles[RBT_VALUES];
    int columns[RBT_VALUES];
    const int n = rbt_components(table, columns);
    rbt_conditions given;
    rbt_report report;
    memset(&given, 0, sizeof given);
    given.alpha1 = c->given;
    given.speed = c->given + 1;
    given.spin = c->spins ? c->given + 2 : NULL;
    given.index = &c->index;
    given.hit = &c->hit;
    set_untouched(RBT_VALUES, states);
    for (int k = 0; k < n; k++) {
        singles[k] = (float)UNTOUCHED;
        expected[k] = c->expected[columns[k]];
        rounded[k] = (double)(float)expected[k];
    }
    const int codes[2] = {
        rbt_sample_batch(table, 1, &given, c->seed, states, NULL, &report),
        rbt_sample_batch(table, 1, &given, c->seed, NULL, singles, NULL),
    };
    for (int k = 0; k < n; k++)
        found[k] = (double)singles[k];
    return codes[0] == c->code && codes[1] == c->code &&
           agree(c->code, n, states, expected, tolerance) &&
           agree(c->code, n, found, rounded, tolerance) && report.row == (c->code < 0 ? 0u : 1u) &&
           report.clamped == (c->code >= 0 && (c->code & RBT_CLAMPED)) &&
           report.extrapolated == (c->code >= 0 && (c->code & RBT_EXTRAPOLATED)) &&
           report.clamped_row == 1u - report.clamped &&
           report.extrapolated_row == 1u - report.extrapolated;
}

/* `moved` is the same table at another address. */
static int check_draw(const rbt_table *table, const rbt_table *moved, const vector_case *c,
                      double tolerance)
{
    const double alpha1 = c->given[0], speed = c->given[1], *spin = c->spins ? c->given + 2 : NULL;
    double values[RBT_VALUES], states[2][6];
    int codes[2], holds = check_columns(table, c, tolerance);
    set_untouched(12, states[0]);
    codes[0] = rbt_draw(moved, alpha1, speed, spin, c->seed, c->index, c->hit, states[0]);
    codes[1] = rbt_draw_batch(table, 1, &alpha1, &speed, spin, c->seed, &c->index, &c->hit,
                              states[1], NULL);
    for (int k = 0; k < 2; k++)
        holds = holds && codes[k] == c->code && agree(c->code, 6, states[k], c->expected, tolerance);
    set_untouched(RBT_VALUES, values);
    return holds &&
           rbt_draw_all(table, alpha1, speed, spin, NULL, c->seed, c->index, c->hit, values) ==
               c->code &&
           agree(c->code, RBT_VALUES, values, c->expected, tolerance);
}

static int check_rebound(const rbt_table *table, const vector_case *c, double tolerance)
{
    const double *v = c->given, *normal = v + 3, *wall = v + 7;
    const double *roughness = c->rough ? v + 10 : NULL;
    const double *omega = c->spins ? v + 10 + c->rough : NULL, tilt = roughness ? *roughness : 0.0;
    double after[3][6];
    int codes[3], holds = 1;
    rbt_impacts impacts;
    memset(&impacts, 0, sizeof impacts);
    impacts.velocity = v;
    impacts.normal = normal;
    impacts.half_size = v + 6;
    impacts.wall_velocity = wall;
    impacts.roughness = roughness;
    impacts.omega = omega;
    impacts.index = &c->index;
    impacts.hit = &c->hit;
    set_untouched(18, after[0]);
    codes[0] = c->rough ? rbt_rough_rebound(table, v, normal, v[6], wall, tilt, omega, c->seed,
                                            c->index, c->hit, after[0], after[0] + 3)
                        : rbt_rebound(table, v, normal, v[6], wall, omega, c->seed, c->index,
                                      c->hit, after[0], after[0] + 3);
    codes[1] = rbt_rebound_grain(table, v, normal, v[6], wall, tilt, 0, omega, NULL, c->seed,
                                 c->index, c->hit, after[1], after[1] + 3);
    codes[2] = rbt_rebound_batch(table, 1, &impacts, c->seed, after[2], after[2] + 3, NULL);
    for (int k = 0; k < 3; k++)
        holds = holds && codes[k] == c->code && agree(c->code, 6, after[k], after[0], tolerance);
    tolerance =
        fmax(tolerance, c->spins ? SPIN_ROUNDING : c->rough ? ROUGH_ROUNDING : LIBRARY_ROUNDING);
    return holds && agree(c->code, 3, after[0], c->expected, tolerance) &&
           agree(c->code, 3, after[0] + 3, c->expected + 3, tolerance);
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
    char line[1024];
    int cases = 0, holds = 1;
    while (holds && fgets(line, sizeof line, file)) {
        vector_case c;
        holds = read_case(line, &c) && (c.draws ? check_draw(table, &moved, &c, tolerance)
                                                : check_rebound(table, &c, tolerance));
        cases++;
    }
    fclose(file);
    rbt_close(table);
    free(memory);
    printf(holds ? "%d cases\n" : "case %d fails\n", cases);
    return !holds;
}
