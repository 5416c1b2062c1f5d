/* Every public function, with records of any kind: fuzz_calls COUNT TABLE.rbt ...

   Each record has arrays of exactly its rows, or NULL, of numbers that are sensible or hostile. A result
   is finite or, where the code is an error, NaN; codes, counts and what a call returns agree. Prints the
   numbers of rows that were drawn and refused. Compiled as C and as C++, with sanitizers too. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t state = 1;

static uint32_t word(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(state >> 33);
}

static double between(double low, double high)
{
    return low + (high - low) * (double)word() / 2147483648.0;
}

static int one_in(uint32_t n)
{
    return word() % n == 0;
}

static const double hostile[] = {0.0,  -1.0,   1e-300, 5e-324, -1e-12, 1.6,  1e150, 1e160,
                                 1e308, -1e200, 1e-9,   0.1,    0.5,    4.0,  6.0};

static int is_finite(double x)
{
    return x - x == 0.0;
}

/* Memory for n numbers and not one more; of a NULL there is nothing to free. */
static double *numbers(size_t n)
{
    double *made = (double *)malloc(n * sizeof *made + 1);
    if (!made)
        exit(3);
    return made;
}

/* n rows of `width` numbers, rarely a hostile one among them; or NULL. */
static double *given(size_t n, size_t width, double low, double high, uint32_t rarely_missing)
{
    if (one_in(rarely_missing))
        return NULL;
    double *array = numbers(n * width);
    for (size_t k = 0; k < n * width; k++) {
        array[k] = between(low, high);
        if (one_in(300))
            array[k] = one_in(4) ? HUGE_VAL - (one_in(2) ? HUGE_VAL : 0.0)
                                 : hostile[word() % (sizeof hostile / sizeof *hostile)];
    }
    return array;
}

static double *given_grains(size_t n)
{
    double *grain = given(n, 3, 0.2, 1.0, 2);
    for (size_t k = 0; k < n && grain; k++)
        if (!one_in(10))
            grain[3 * k] = (double)(word() % 5);
    return grain;
}

static void fail(const char *what)
{
    puts(what);
    exit(1);
}

/* Whether n numbers are NaN, or else finite. */
static void check(const double *results, size_t row, size_t width, int code)
{
    for (size_t c = 0; c < width && results; c++) {
        const double x = results[row * width + c];
        if (code < 0 ? x == x : !is_finite(x))
            fail("a result is not what its code says");
    }
}

/* Whether a row has what it came with, or 0. */
static void check_kept(const double *results, const double *before, size_t row, size_t width)
{
    const double none[3] = {0.0, 0.0, 0.0};
    if (results && memcmp(results + row * width, before ? before + row * width : none,
                          width * sizeof *none) != 0)
        fail("a particle that recedes is changed");
}

static int has_works(const rbt_table *table)
{
    int columns[RBT_VALUES], found = 0;
    rbt_variables(table, columns);
    for (int k = 0; k < RBT_VALUES; k++)
        found += columns[k] == RBT_WORK_NORMAL || columns[k] == RBT_WORK_SHEAR;
    return found == 2;
}

typedef struct tally {
    size_t drawn, refused, first;
    int flags, error;
    size_t kinds[8];
} tally;

static void count(tally *t, int code, size_t row)
{
    if (code < 0) {
        if (t->refused++ == 0) {
            t->first = row;
            t->error = code;
        }
        return;
    }
    t->drawn++;
    t->flags |= code;
    for (int k = 0; k < 4; k++)
        t->kinds[k] += (size_t)(code >> k & 1);
}

static void draw(const rbt_table *table, size_t n, const uint64_t *index, const uint32_t *hit,
                 tally *all)
{
    rbt_conditions c;
    tally t = {0, 0, n, 0, 0, {0, 0, 0, 0}};
    const size_t width = (size_t)rbt_variables(table, NULL);
    double *alpha1 = given(n, 1, 0.001, 1.58, 50), *speed = given(n, 1, 1.0, 400.0, 50);
    double *spin = given(n, 3, -3.0, 3.0, 2), *grain = given_grains(n);
    double *inertia = given(n, 1, 0.0, 0.7, 2), *after = one_in(2) ? NULL : numbers(n);
    double *states = one_in(10) ? NULL : numbers(n * width);
    int *codes = one_in(10) ? NULL : (int *)malloc(n * sizeof(int) + 1);
    memset(&c, 0, sizeof c);
    c.alpha1 = alpha1, c.speed = speed, c.spin = spin, c.inertia = inertia, c.grain = grain;
    c.inertia_after = after;
    c.index = one_in(50) ? NULL : index, c.hit = one_in(50) ? NULL : hit;
    c.fresh = one_in(2);
    const int code = rbt_sample(table, n, &c, word(), states, codes);
    const int missing = !alpha1 || !speed || !c.index || !c.hit;
    if (missing != (code == RBT_ERR_MISSING))
        fail("a missing array is not told");
    for (size_t k = 0; k < n && !missing && codes; k++) {
        count(&t, codes[k], k);
        check(states, k, width, codes[k]);
        check(states ? after : NULL, k, 1, codes[k]);
    }
    if (!missing && codes && code != (t.refused ? t.error : t.flags))
        fail("a draw does not return what its rows say");
    all->drawn += t.drawn, all->refused += t.refused;
    free(alpha1), free(speed), free(spin), free(inertia), free(grain), free(states), free(codes);
    free(after);
}

static void rebound(const rbt_table *table, size_t n, const uint64_t *index, const uint32_t *hit,
                    tally *all)
{
    rbt_impacts m;
    rbt_rebounds out;
    tally t = {0, 0, n, 0, 0, {0, 0, 0, 0}};
    double *velocity = given(n, 3, -200.0, 200.0, 50), *normal = given(n, 3, -1.0, 1.0, 50);
    double *half_size = given(n, 1, 1e-6, 1e-3, 50), *wall = given(n, 3, -5.0, 5.0, 2);
    double *omega = given(n, 3, -1e6, 1e6, 2), *roughness = given(n, 1, 0.0, 0.5, 2);
    double *grain = given_grains(n), *inertia = given(n, 1, 0.0, 0.7, 2);
    memset(&m, 0, sizeof m);
    memset(&out, 0, sizeof out);
    m.velocity = velocity, m.normal = normal, m.half_size = half_size, m.wall_velocity = wall;
    m.omega = omega, m.inertia = inertia, m.roughness = roughness, m.grain = grain;
    m.index = one_in(50) ? NULL : index, m.hit = one_in(50) ? NULL : hit;
    m.fresh = one_in(2), m.isotropic = one_in(2);
    out.velocity = one_in(10) ? NULL : numbers(3 * n);
    out.omega = one_in(10) ? NULL : numbers(3 * n);
    out.inertia = one_in(10) ? NULL : numbers(n);
    out.works = one_in(has_works(table) ? 2 : 99) ? numbers(2 * n) : NULL;
    out.codes = one_in(10) ? NULL : (int *)malloc(n * sizeof(int) + 1);
    const int code = rbt_rebound(table, n, &m, word(), &out);
    const int missing = !velocity || !normal || !half_size || !m.index || !m.hit;
    const int lacking = !missing && out.works && !has_works(table);
    if (missing != (code == RBT_ERR_MISSING) || lacking != (code == RBT_ERR_NO_WORKS))
        fail("a missing array, or one of works, is not told");
    for (size_t k = 0; k < n && !missing && !lacking && out.codes; k++) {
        count(&t, out.codes[k], k);
        check(out.works, k, 2, out.codes[k]);
        if (out.codes[k] == RBT_ERR_NOT_APPROACHING) {
            check_kept(out.velocity, velocity, k, 3);
            check_kept(out.omega, omega, k, 3);
            check_kept(out.inertia, inertia, k, 1);
            continue;
        }
        check(out.velocity, k, 3, out.codes[k]);
        check(out.omega, k, 3, out.codes[k]);
        check(out.inertia, k, 1, out.codes[k]);
    }
    if (!missing && !lacking && out.codes &&
        (code != (t.refused ? t.error : t.flags) || out.bad != t.refused || out.first_bad != t.first ||
         memcmp(out.flagged, t.kinds, sizeof t.kinds) != 0))
        fail("a rebound does not report what its rows say");
    all->drawn += t.drawn, all->refused += t.refused;
    free(velocity), free(normal), free(half_size), free(wall), free(omega), free(roughness);
    free(grain), free(inertia), free(out.velocity), free(out.omega), free(out.inertia);
    free(out.works), free(out.codes);
}

/* Copies of a table, its grains, and the gas. */
static void ask(const rbt_table *table, size_t n, const uint64_t *index, const uint32_t *hit)
{
    const double omega[3] = {3.0, -4.0, 0.0};
    double *grains = numbers(3 * n), torque[3], after[3];
    size_t size;
    const int code = rbt_grains(table, n, 7, index, one_in(2) ? NULL : hit, grains);
    const void *image = rbt_image(table, &size);
    const rbt_table moved = rbt_moved(table, image), unchecked = rbt_unchecked(image, size);
    rbt_table *again;
    if (rbt_open_memory(image, size, &again) != RBT_OK)
        fail("an image is refused");
    rbt_close(again);
    if ((code == RBT_OK) != rbt_has_spin_law(&moved) || rbt_variables(&unchecked, NULL) < 1 ||
        !(rbt_mean_half_size(table, 1e-4) >= 0.0))
        fail("a query fails");
    for (size_t k = 0; k < n && code == RBT_OK; k++)
        if (!(rbt_half_size(table, 1e-4, grains + 3 * k) > 0.0))
            fail("a grain has no size");
    rbt_gas_torque(omega, 1e-4, 1.2, one_in(9) ? 0.0 : 1.8e-5, NULL, torque);
    rbt_spin_after(omega, 1e-3, 1e-20, 1e-4, 1.2, one_in(9) ? 0.0 : 1.8e-5, omega, after);
    if (!is_finite(torque[0]) || !is_finite(after[0]))
        fail("the gas gives NaN");
    free(grains);
}

int main(int argc, char **argv)
{
    tally all = {0, 0, 0, 0, 0, {0, 0, 0, 0}};
    const long records = argc > 1 ? strtol(argv[1], NULL, 10) : 0;
    for (int file = 2; file < argc; file++) {
        rbt_table *table;
        if (rbt_open(argv[file], &table) != RBT_OK)
            fail(argv[file]);
        for (long k = 0; k < records; k++) {
            const size_t n = one_in(8) ? 0 : word() % (one_in(8) ? 70 : 4);
            uint64_t *index = (uint64_t *)malloc(n * sizeof *index + 1);
            uint32_t *hit = (uint32_t *)malloc(n * sizeof *hit + 1);
            if (!index || !hit)
                return 3;
            for (size_t r = 0; r < n; r++) {
                index[r] = (uint64_t)word() << 32 | word();
                hit[r] = word();
            }
            if (k % 2)
                draw(table, n, index, hit, &all);
            else
                rebound(table, n, index, hit, &all);
            if (k % 200 == 0)
                ask(table, n, index, hit);
            free(index), free(hit);
        }
        rbt_close(table);
    }
    printf("%lu %lu\n", (unsigned long)all.drawn, (unsigned long)all.refused);
    return all.drawn == 0 || all.refused == 0;
}
