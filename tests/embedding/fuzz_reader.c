/* Fuzzing of the image reader: whatever the bytes, no access outside them, when they are read and when
   states are drawn from an image that is accepted. Numbers of such an image may be anything.

       clang -g -O2 -fsanitize=fuzzer,address,undefined -I... fuzz_reader.c -o fuzz -lm
       RBT_FUZZ_IMAGES="plane.rbt works.rbt" ./fuzz -max_total_time=20 CORPUS

   An input that begins like an image is one. Any other is a list of edits to one of the good images:
   a byte that selects it, then for each edit an offset (2 bytes), a width (1) and a value (8). Then
   format, size and checksum are made right, so that the checks behind these are reached. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include <stdio.h>

#define DRAWS 40
#define EDIT 11
#define MOST_IMAGES 8

static char *images[MOST_IMAGES];
static size_t sizes[MOST_IMAGES], n_images;

static void need(int holds)
{
    if (!holds)
        abort();
}

/* Draws and rebounds of every kind, in a block and one by one. */
static void check_draws(const rbt_table *table)
{
    double alpha1[DRAWS], speed[DRAWS], spin[3 * DRAWS], states[RBT_VALUES * DRAWS], one[RBT_VALUES];
    double velocity[3 * DRAWS], normal[3 * DRAWS], size[DRAWS], grains[3 * DRAWS];
    uint64_t index[DRAWS];
    uint32_t hit[DRAWS];
    rbt_range range;
    need(rbt_covered(table, &range) == RBT_OK && rbt_pair(table)[127] == 0);
    for (int k = 0; k < DRAWS; k++) {
        alpha1[k] = 0.02 + 1.5 * (k % 8) / 7.0;
        speed[k] = 10.0 + 40.0 * (k / 8);
        index[k] = (uint64_t)k * 0x9E3779B97F4A7C15u;
        hit[k] = (uint32_t)k;
        size[k] = 1e-5;
        for (int m = 0; m < 3; m++) {
            spin[3 * k + m] = ((7 * k + m) % 11 - 5) * (k < DRAWS / 2 ? 0.2 : 3.0) * (k % 4 != 0);
            velocity[3 * k + m] = (m == 1 ? -30.0 : 20.0) - k;
            normal[3 * k + m] = m == 1;
        }
    }
    for (int spinning = 0; spinning < 2; spinning++) {
        rbt_conditions of = {0};
        of.alpha1 = alpha1, of.speed = speed, of.index = index, of.hit = hit;
        of.spin = spinning ? spin : NULL;
        const int known = !spinning || rbt_has_spin_law(table);
        need((rbt_sample(table, DRAWS, &of, 1, states, NULL) >= RBT_OK) == known);
        for (size_t k = 0; k < DRAWS; k++) {
            of.alpha1 = alpha1 + k, of.speed = speed + k, of.index = index + k, of.hit = hit + k;
            of.spin = spinning ? spin + 3 * k : NULL;
            need((rbt_sample(table, 1, &of, 1, one, NULL) >= RBT_OK) == known);
        }
    }
    need((rbt_grains(table, DRAWS, 1, index, NULL, grains) == RBT_OK) == rbt_has_spin_law(table));
    rbt_impacts given = {0};
    given.velocity = velocity, given.normal = normal, given.half_size = size;
    given.index = index, given.hit = hit, given.fresh = 1;
    rbt_rebounds after = {0};
    after.velocity = velocity;
    need(rbt_rebound(table, DRAWS, &given, 1, &after) != RBT_ERR_MISSING);
}

static void repair(char *image, size_t size)
{
    rbti_header header;
    const size_t at = offsetof(rbti_header, sha256);
    memcpy(&header, image, sizeof header);
    memcpy(header.magic, "\x89RBT\r\n\x1a\n", 8);
    header.major = RBTI_MAJOR;
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
