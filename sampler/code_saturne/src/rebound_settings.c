/* rebound_settings.c - read the settings of wall rebounds and open the table.

   Lines are `name value`; `#` begins a comment. A mistake ends the run with one line, which names the
   file and the setting. It says what the value is and what is allowed, or what is wrong and what to do.
   Part of rebound-tables; MIT licence. */

#include <dlfcn.h>
#include <errno.h>
#include <float.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* code_saturne asks for this warning; the header compares with exact zeros on purpose. */
#pragma GCC diagnostic ignored "-Wfloat-equal"
#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "bft_error.h"

#include "rebound_wall.h"

/* The value of `spin` until the table is known: yes if the table has a spin law. */
enum { SPIN_IF_POSSIBLE = -1 };

#define DEGREE (3.14159265358979323846 / 180.0)

/* End the run because of the value of a setting. */
static void refuse(const char *name, const char *value, const char *allowed)
{
    bft_error(__FILE__, __LINE__, 0, "%s: %s: got %s, allowed: %s", REBOUND_SETTINGS_FILE, name,
              value, allowed);
}

/* End the run because of a setting that is missing, or does not go together with others; say what to do. */
static void refuse_setting(const char *name, const char *problem)
{
    bft_error(__FILE__, __LINE__, 0, "%s: %s: %s", REBOUND_SETTINGS_FILE, name, problem);
}

/* Read a whole number of 64 bits. */
static uint64_t read_seed(const char *text)
{
    char *end = NULL;
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (*end != '\0' || end == text || text[0] == '-' || text[0] == '+' || errno == ERANGE)
        refuse("seed", text, "0 to 18446744073709551615");
    return (uint64_t)value;
}

/* Return 0 or 1 for the first or the second of two words. */
static int read_choice(const char *name, const char *text, const char *zero, const char *one)
{
    char allowed[32];
    snprintf(allowed, sizeof allowed, "%s, %s", zero, one);
    if (strcmp(text, zero) != 0 && strcmp(text, one) != 0)
        refuse(name, text, allowed);
    return strcmp(text, one) == 0;
}

/* Settings that are numbers. */
static const struct {
    const char *name;
    size_t offset;
    double least, most;
    const char *allowed;
} numbers[] = {
    {"half_size", offsetof(rebound_settings_t, half_size), 1e-12, DBL_MAX, "a positive number"},
    {"gas_torque", offsetof(rebound_settings_t, gas_torque), 0, DBL_MAX, "0 or a positive number"},
    {"deposit_speed", offsetof(rebound_settings_t, deposit_speed), 0, DBL_MAX,
     "0 or a positive speed in m/s"},
    {"deposit_diameter", offsetof(rebound_settings_t, deposit_diameter), 1e-30, DBL_MAX,
     "a positive length in m"},
    {"histogram_speed", offsetof(rebound_settings_t, histogram_speed), 1e-30, DBL_MAX,
     "a positive speed in m/s"},
    {"tilt_deg", offsetof(rebound_settings_t, tilt_deg), 0, 28.6, "0 to 28.6 deg"},
    {"Ra", offsetof(rebound_settings_t, ra), 0, DBL_MAX, "0 or a positive length in m"},
    {"Rq", offsetof(rebound_settings_t, rq), 0, DBL_MAX, "0 or a positive length in m"},
    {"RSm", offsetof(rebound_settings_t, rsm), 1e-30, DBL_MAX, "a positive length in m"},
};

/* Read a setting that is a number; 0 if none has that name. */
static int take_number(rebound_settings_t *settings, const char *name, const char *text)
{
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        char *end = NULL;
        const double value = strtod(text, &end);
        if (strcmp(name, numbers[i].name) != 0)
            continue;
        if (*end != '\0' || end == text || !(value >= numbers[i].least && value <= numbers[i].most))
            refuse(name, text, numbers[i].allowed);
        *(double *)((char *)settings + numbers[i].offset) = value;
        return 1;
    }
    return 0;
}

/* Take a line of the file. */
static void take(rebound_settings_t *settings, int *has_seed, const char *name, const char *value)
{
    if (strcmp(name, "table") == 0) {
        snprintf(settings->table, sizeof settings->table, "%s", value);
    } else if (strcmp(name, "direct") == 0) {
        /* a name alone would be looked for among the libraries of the system */
        snprintf(settings->direct, sizeof settings->direct, "%s%s", strchr(value, '/') ? "" : "./",
                 value);
    } else if (strcmp(name, "seed") == 0) {
        settings->seed = read_seed(value);
        *has_seed = 1;
    } else if (strcmp(name, "spin") == 0) {
        settings->spin = read_choice(name, value, "no", "yes");
    } else if (strcmp(name, "out_of_range") == 0) {
        settings->refuse_outside = read_choice(name, value, "clamp", "error");
    } else if (strcmp(name, "face_sums") == 0) {
        settings->face_sums = read_choice(name, value, "no", "yes");
    } else if (strcmp(name, "face_histograms") == 0) {
        settings->face_histograms = read_choice(name, value, "no", "yes");
    } else if (strcmp(name, "isotropic") == 0) {
        settings->isotropic = read_choice(name, value, "no", "yes");
    } else if (!take_number(settings, name, value)) {
        refuse_setting(name, "no setting has this name; the names are table, direct, seed, spin, "
                             "out_of_range, half_size, gas_torque, deposit_speed, deposit_diameter, "
                             "face_sums, face_histograms, histogram_speed, tilt_deg, isotropic, Ra, Rq, "
                             "RSm");
    }
}

/* Read all lines of the file. */
static void read_file(rebound_settings_t *settings)
{
    char line[512], name[64], value[256], more[2];
    int has_seed = 0;
    FILE *file = fopen(REBOUND_SETTINGS_FILE, "r");
    if (file == NULL)
        bft_error(__FILE__, __LINE__, 0, REBOUND_SETTINGS_FILE ": the file is missing; put it into DATA");
    while (fgets(line, sizeof line, file) != NULL) {
        line[strcspn(line, "#\n")] = '\0';
        const int words = sscanf(line, "%63s %255s %1s", name, value, more);
        if (words == 2)
            take(settings, &has_seed, name, value);
        else if (words > 0)
            refuse_setting(name, words == 1 ? "the value is missing; write `name value`"
                                            : "the line has more than one value; write `name value`");
    }
    fclose(file);
    if (settings->table[0] == '\0')
        refuse_setting("table", "the setting is missing; give a file that `sampler export` wrote");
    if (!has_seed)
        refuse_setting("seed", "the setting is missing; give a number from 0 to 18446744073709551615");
}

/* Let the table simulate, by the law in a shared library, which stays open. */
static void use_direct(rbt_table *table, const char *path)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const void *law = library != NULL ? dlsym(library, "rebound_direct") : NULL;
    if (law == NULL)
        bft_error(__FILE__, __LINE__, 0, "%s: direct: %s; run: tablegen export-direct PAIR --output DIR, "
                  "and in DIR: gcc -shared rebound_direct.o -lm -o rebound_direct.so",
                  REBOUND_SETTINGS_FILE, dlerror());
    const int code = rbt_use_direct(table, law);
    if (code < RBT_OK)
        bft_error(__FILE__, __LINE__, 0, "%s: direct: %s: %s", REBOUND_SETTINGS_FILE, path,
                  rbt_strerror(code));
}

/* Fill the settings that were not given from the table, and refuse those that the table cannot fulfil. */
static void check_table(rebound_settings_t *settings, const rbt_table *table)
{
    int has_spin = rbt_has_spin_law(table);
    for (int k = RBT_OMEGA_X; k <= RBT_OMEGA_Z; k++)
        has_spin = has_spin && rbt_has_variable(table, k);
    for (int k = RBT_U; k <= RBT_W; k++)
        if (!rbt_has_variable(table, k))
            refuse_setting("table", "the table lacks a component of the velocity; give one with u, v, w");
    if (settings->spin == SPIN_IF_POSSIBLE)
        settings->spin = has_spin;
    if (settings->spin && !has_spin)
        refuse_setting("spin", "the table has no spin law; write `spin no`, or give another table");
    if (settings->half_size == 0.0) /* only a spin depends on it */
        settings->half_size = has_spin ? rbt_mean_half_size(table, 1.0) : 0.5;
    if (settings->face_histograms && settings->histogram_speed == 0.0)
        settings->histogram_speed = rbt_highest_speed(table);
    if (settings->face_histograms && settings->histogram_speed == 0.0)
        refuse_setting("histogram_speed", "the setting is missing, and the table has no highest speed; "
                                          "give a speed in m/s");
    if (settings->gas_torque < 0.0) /* not given */
        settings->gas_torque = settings->spin;
    if (!settings->spin && settings->gas_torque > 0.0)
        refuse_setting("gas_torque", "particles keep no spin for the gas to slow; write `gas_torque 0`");
}

double rebound_settings_roughness(const rebound_settings_t *settings, double diameter)
{
    double tilt;
    if (settings->rsm <= 0.0)
        return settings->tilt_deg * DEGREE;
    if (rbt_wall_tilt(settings->ra, settings->rq, settings->rsm, diameter, &tilt) < RBT_OK)
        refuse_setting("RSm", "the facets of the profile are too steep; Ra and Rq may be up to 0.27 RSm");
    return tilt;
}

/* Refuse a profile that is not whole, or beside a tilt. */
static void check_profile(const rebound_settings_t *settings)
{
    const int profile = settings->ra > 0.0 || settings->rq > 0.0 || settings->rsm > 0.0;
    if (profile && settings->tilt_deg > 0.0)
        refuse_setting("tilt_deg", "Ra, Rq and RSm give a tilt as well; leave out one of the two");
    if (profile && settings->rsm <= 0.0)
        refuse_setting("RSm", "the setting is missing; give it in m, with Ra and Rq");
    if (settings->isotropic && !profile && settings->tilt_deg <= 0.0)
        refuse_setting("isotropic", "the walls are smooth; write `isotropic no`, or give a roughness");
}

struct rbt_table *rebound_settings_read(rebound_settings_t *settings)
{
    const rebound_settings_t defaults = {.spin = SPIN_IF_POSSIBLE, .gas_torque = -1.0};
    rbt_table *table = NULL;
    *settings = defaults;
    read_file(settings);
    check_profile(settings);
    const int code = rbt_open(settings->table, &table);
    if (code < RBT_OK)
        bft_error(__FILE__, __LINE__, 0, "%s: table: %s: %s; give a file that `sampler export` wrote",
                  REBOUND_SETTINGS_FILE, settings->table, rbt_strerror(code));
    if (settings->direct[0] != '\0')
        use_direct(table, settings->direct);
    check_table(settings, table);
    return table;
}
