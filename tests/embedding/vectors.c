/* Known-answer vectors through the C header: vectors TABLE.rbt VECTORS.txt TOLERANCE

   Compiled as C and as C++. A tolerance of 0 asks for the same bits from every draw; rebounds, which
   call atan2, cos and sin of the C library, may differ in the last digits. Prints the number of
   cases, or the first case that fails. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <stdio.h>

#define UNTOUCHED 12345.0
#define LIBRARY_ROUNDING 1e-13
#define ROUGH_ROUNDING 1e-12
/* a last digit of an angle may turn the last digit of a feature, in single precision */
#define SPIN_ROUNDING 1e-5

static int next_numbers(char **text, int n, double *numbers)
{
    for (int k = 0; k < n; k++) {
        char *end;
        numbers[k] = strtod(*text, &end);
        if (end == *text)
            return 0;
        *text = end;
    }
    return 1;
}

static uint64_t next_integer(char **text)
{
    return strtoull(*text, text, 10);
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

/* `moved` is the same table at another address. */
static int check_draw(const rbt_table *table, const rbt_table *moved, char *text, double tolerance)
{
    double condition[2], expected[8], values[8], state[6], row[6];
    if (!next_numbers(&text, 2, condition))
        return 0;
    const uint64_t seed = next_integer(&text), index = next_integer(&text);
    const uint32_t hit = (uint32_t)next_integer(&text);
    const int code = (int)strtol(text, &text, 10);
    if (!next_numbers(&text, 8, expected))
        return 0;
    set_untouched(8, values);
    set_untouched(6, state);
    set_untouched(6, row);
    rbt_report report;
    const int codes[3] = {
        rbt_draw_all(table, condition[0], condition[1], seed, index, hit, values),
        rbt_draw(moved, condition[0], condition[1], NULL, seed, index, hit, state),
        rbt_draw_batch(table, 1, condition, condition + 1, NULL, seed, &index, &hit, row, &report),
    };
    return codes[0] == code && codes[1] == code && codes[2] == code &&
           report.row == (code < 0 ? 0u : 1u) && report.clamped == (code > 0 ? 1u : 0u) &&
           report.clamped_row == (code > 0 ? 0u : 1u) &&
           agree(code, 8, values, expected, tolerance) &&
           agree(code, 6, state, expected, tolerance) && agree(code, 6, row, expected, tolerance);
}

/* spin-draw ALPHA1 SPEED SPIN*3 SEED INDEX HIT CODE STATE*6 */
static int check_spin_draw(const rbt_table *table, const rbt_table *moved, char *text,
                           double tolerance)
{
    double given[5], expected[6], state[6], row[6];
    if (!next_numbers(&text, 5, given))
        return 0;
    const uint64_t seed = next_integer(&text), index = next_integer(&text);
    const uint32_t hit = (uint32_t)next_integer(&text);
    const int code = (int)strtol(text, &text, 10);
    if (!next_numbers(&text, 6, expected))
        return 0;
    set_untouched(6, state);
    set_untouched(6, row);
    const int codes[2] = {
        rbt_draw(moved, given[0], given[1], given + 2, seed, index, hit, state),
        rbt_draw_batch(table, 1, given, given + 1, given + 2, seed, &index, &hit, row, NULL),
    };
    return codes[0] == code && codes[1] == code && agree(code, 6, state, expected, tolerance) &&
           agree(code, 6, row, expected, tolerance);
}

/* [spin-]rebound VELOCITY*3 NORMAL*3 HALF_SIZE WALL_VELOCITY*3 [OMEGA*3] SEED INDEX HIT CODE
   VELOCITY*3 OMEGA*3; rough-rebound and spin-rough have ROUGHNESS behind the velocity of the wall. */
static int check_rebound(const rbt_table *table, int rough, int spins, char *text, double tolerance)
{
    double given[14], expected[6], result[6], row[6];
    if (!next_numbers(&text, 10 + (rough ? 1 : 0) + (spins ? 3 : 0), given))
        return 0;
    const uint64_t seed = next_integer(&text), index = next_integer(&text);
    const uint32_t hit = (uint32_t)next_integer(&text);
    const int code = (int)strtol(text, &text, 10);
    if (!next_numbers(&text, 6, expected))
        return 0;
    const double *velocity = given, *normal = given + 3, *wall_velocity = given + 7;
    const double *roughness = rough ? given + 10 : NULL;
    const double *omega = spins ? given + 10 + (rough ? 1 : 0) : NULL;
    set_untouched(6, result);
    const int got = rough ? rbt_rough_rebound(table, velocity, normal, given[6], wall_velocity,
                                              *roughness, omega, seed, index, hit, result, result + 3)
                          : rbt_rebound(table, velocity, normal, given[6], wall_velocity, omega, seed,
                                        index, hit, result, result + 3);
    rbt_impacts impacts;
    memset(&impacts, 0, sizeof impacts);
    impacts.velocity = velocity;
    impacts.normal = normal;
    impacts.half_size = given + 6;
    impacts.wall_velocity = wall_velocity;
    impacts.roughness = roughness;
    impacts.omega = omega;
    impacts.index = &index;
    impacts.hit = &hit;
    set_untouched(6, row);
    if (rbt_rebound_batch(table, 1, &impacts, seed, row, row + 3, NULL) != got ||
        !agree(got, 3, row, result, tolerance) || !agree(got, 3, row + 3, result + 3, tolerance))
        return 0;
    tolerance = fmax(tolerance, spins ? SPIN_ROUNDING : rough ? ROUGH_ROUNDING : LIBRARY_ROUNDING);
    return got == code && agree(code, 3, result, expected, tolerance) &&
           agree(code, 3, result + 3, expected + 3, tolerance);
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
    int cases = 0, failed = 0;
    while (!failed && fgets(line, sizeof line, file)) {
        int holds = 0;
        if (strncmp(line, "draw ", 5) == 0)
            holds = check_draw(table, &moved, line + 5, tolerance);
        else if (strncmp(line, "rebound ", 8) == 0)
            holds = check_rebound(table, 0, 0, line + 8, tolerance);
        else if (strncmp(line, "spin-draw ", 10) == 0)
            holds = check_spin_draw(table, &moved, line + 10, tolerance);
        else if (strncmp(line, "spin-rebound ", 13) == 0)
            holds = check_rebound(table, 0, 1, line + 13, tolerance);
        else if (strncmp(line, "rough-rebound ", 14) == 0)
            holds = check_rebound(table, 1, 0, line + 14, tolerance);
        else if (strncmp(line, "spin-rough ", 11) == 0)
            holds = check_rebound(table, 1, 1, line + 11, tolerance);
        failed = !holds;
        cases++;
        if (failed)
            printf("case %d fails: %s", cases, line);
    }
    fclose(file);
    rbt_close(table);
    free(memory);
    if (!failed)
        printf("%d cases\n", cases);
    return failed;
}
