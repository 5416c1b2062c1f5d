/* Fuzzing of the image reader: whatever the bytes, no access outside them, and every draw from an
   image that is accepted is finite and physical.

       clang -g -O2 -fsanitize=fuzzer,address,undefined -I... fuzz_reader.c -o fuzz -lm
       RBT_FUZZ_IMAGES="plane.rbt works.rbt" ./fuzz -max_total_time=20 CORPUS

   An input that begins like an image is one. Any other is a list of edits to one of the good images:
   a byte that selects it, then for each edit an offset (2 bytes), a width (1) and a value (8). Then
   format, size and checksum are made right, so that the checks behind these are reached. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <stdio.h>

#define DRAWS 25
#define EDIT 11
#define MOST_IMAGES 8

static char *images[MOST_IMAGES];
static size_t sizes[MOST_IMAGES], n_images;

static void need(int holds)
{
    if (!holds)
        abort();
}

/* Whether a draw has no more energy than its own grain can have before. */
static int keeps_energy(const rbt_table *table, const double *spin, const double *grain,
                        const double *state)
{
    const rbt_spin_law *law = &table->spin;
    const double b = grain[1] * grain[1], c = grain[2] * grain[2];
    double j1 = 2.0 / 3.0, j3 = 0.0;
    if (law->shape_inertia) {
        const double *of = law->shape_inertia + 2 * rbti_row_of_shape(law, grain[0]);
        j1 = of[0] * (1.0 + b);
        j3 = of[1] * b * (1.0 + c);
    }
    const double before = 1.0 + j1 * rbti_dot(spin, spin);
    return rbti_dot(state, state) + j3 * rbti_dot(state + 3, state + 3) <= before * (1.0 + 1e-12);
}

/* Draws of particles that spin, or refusals of a table without a spin law. */
static void check_spinning(const rbt_table *table, const double *alpha1, const double *speed,
                           const uint64_t *index, const uint32_t *hit)
{
    double spin[3 * DRAWS], states[6 * DRAWS], state[6], grain[3];
    for (int k = 0; k < 3 * DRAWS; k++)
        spin[k] = ((k * 7) % 11 - 5) * (k < 3 * DRAWS / 2 ? 0.2 : 3.0) * (k % 4 != 0);
    const int code = rbt_draw_batch(table, DRAWS, alpha1, speed, spin, 1, index, hit, states, NULL);
    need(code == RBT_ERR_NO_SPIN_LAW ? !rbt_has_spin_law(table) : code >= RBT_OK);
    for (int k = 0; k < DRAWS && code >= RBT_OK; k++) {
        const double *s = spin + 3 * k, *row = states + 6 * k;
        need(rbt_draw(table, alpha1[k], speed[k], s, 1, index[k], hit[k], state) >= RBT_OK);
        need(memcmp(state, row, sizeof state) == 0);
        for (int m = 0; m < 6; m++)
            need(rbti_finite(state[m]));
        need(state[1] > 0.0 || !(table->held & 2u));
        need(rbt_grain(table, 1, index[k], hit[k], grain) == RBT_OK);
        int unique = 1; /* a draw takes the row of the grain, which a code may have twice */
        for (int m = 1; m < table->spin.n_shapes; m++)
            unique &= table->spin.shape_codes[m] > table->spin.shape_codes[m - 1];
        need(!unique || keeps_energy(table, s, grain, state));
        need(grain[1] >= 1e-3 && grain[1] <= 1.0 && grain[2] >= 1e-3 && grain[2] <= 1.0);
    }
}

static void check_draws(const rbt_table *table)
{
    double alphas[2], speeds[2], alpha1[DRAWS], speed[DRAWS], states[6 * DRAWS], values[RBT_VALUES];
    uint64_t index[DRAWS];
    uint32_t hit[DRAWS];
    rbt_alpha_range(table, alphas);
    rbt_speed_range(table, speeds);
    for (int k = 0; k < DRAWS; k++) {
        const double f = (k % 5) / 4.0, g = (k / 5 % 5) / 4.0;
        alpha1[k] = alphas[0] + f * (alphas[1] - alphas[0]);
        speed[k] = speeds[0] + g * (speeds[1] - speeds[0]);
        index[k] = (uint64_t)k * 0x9E3779B97F4A7C15u;
        hit[k] = (uint32_t)k;
    }
    need(rbt_draw_batch(table, DRAWS, alpha1, speed, NULL, 1, index, hit, states, NULL) >= RBT_OK);
    for (int k = 0; k < DRAWS; k++) {
        need(rbt_draw_all(table, alpha1[k], speed[k], NULL, NULL, 1, index[k], hit[k], values) >= RBT_OK);
        for (int m = 0; m < RBT_VALUES; m++)
            need(rbti_finite(values[m]));
        need(memcmp(values, states + 6 * k, 6 * sizeof *values) == 0);
        const double energy = rbti_dot(values, values);
        const double turning = table->least_inertia * rbti_dot(values + 3, values + 3);
        need(energy + turning <= 1.0 + 1e-12 || table->spin.for_first);
        need(values[1] >= 0.0 && values[1] < 1.0 && energy <= 1.0 + 1e-12);
        need(values[6] >= 0.0 && energy + values[6] <= 1.0 + 1e-12);
    }
    check_spinning(table, alpha1, speed, index, hit);
    need(rbt_pair(table)[127] == 0);
}

static void repair(char *image, size_t size)
{
    rbti_header header;
    const size_t at = offsetof(rbti_header, sha256);
    memcpy(&header, image, sizeof header);
    memcpy(header.magic, "\x89RBT\r\n\x1a\n", 8);
    header.major = 1;
    header.minor = 3;
    header.file_bytes = size;
    memcpy(image, &header, sizeof header);
    uint8_t *bytes = (uint8_t *)image;
    rbti_sha256(bytes, at, bytes + at + 32, size - at - 32, bytes + at);
}

/* Copy of bytes at an address and of a size that let the sanitizer see every access outside. */
static char *copied(const void *bytes, size_t size)
{
    void *copy;
    need(posix_memalign(&copy, 64, size + (size == 0)) == 0);
    if (size > 0)
        memcpy(copy, bytes, size);
    return (char *)copy;
}

static char *edited(const uint8_t *data, size_t size, size_t *image_size)
{
    const size_t which = data[0] % n_images;
    char *image = copied(images[which], sizes[which]);
    *image_size = sizes[which];
    for (const uint8_t *edit = data + 1; edit + EDIT <= data + size; edit += EDIT) {
        const size_t at = (size_t)(edit[0] | edit[1] << 8) % *image_size;
        const size_t width = (size_t)1 << edit[2] % 4;
        memcpy(image + at, edit + 3, width < *image_size - at ? width : *image_size - at);
    }
    repair(image, *image_size);
    return image;
}

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    const char *names = getenv("RBT_FUZZ_IMAGES");
    char *list = strdup(names ? names : "");
    for (char *name = strtok(list, " "); name && n_images < MOST_IMAGES; name = strtok(NULL, " ")) {
        rbt_table *table;
        need(rbt_open(name, &table) == RBT_OK);
        const void *image = rbt_image(table, &sizes[n_images]);
        images[n_images] = copied(image, sizes[n_images]);
        n_images++;
        rbt_close(table);
    }
    free(list);
    need(n_images > 0);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    size_t image_size = size;
    const int whole = size == 0 || data[0] == 0x89;
    char *image = whole ? copied(data, size) : edited(data, size, &image_size);
    rbt_table *table;
    const int code = rbt_open_memory(image, image_size, &table);
    need(code == RBT_OK ? table != NULL : code < RBT_OK && table == NULL);
    if (code == RBT_OK)
        check_draws(table);
    rbt_close(table);
    free(image);
    return 0;
}
