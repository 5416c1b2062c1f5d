/* rebound_settings.c - the settings of wall rebounds, from a text file to a table that is open.

   Lines are `name value`; `#` begins a comment. What is wrong ends the run with one line
   "rebound_wall.cfg: NAME: got X, allowed: Y". Part of rebound-tables; MIT licence. */

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* code_saturne asks for this warning; the header compares with exact zeros on purpose. */
#pragma GCC diagnostic ignored "-Wfloat-equal"
#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "bft_error.h"

#include "rebound_wall.h"

enum { SPIN_IF_POSSIBLE = -1 };

#define DEGREE (3.14159265358979323846 / 180.0)

static void refuse(const char *name, const char *got, const char *allowed)
{
    bft_error(__FILE__, __LINE__, 0, "%s: %s: got %s, allowed: %s", REBOUND_SETTINGS_FILE, name,
              got, allowed);
}

static double read_number(const char *name, const char *text, double least, double most,
                          const char *allowed)
{
    char *end = NULL;
    const double value = strtod(text, &end);
    if (*end != '\0' || end == text || !(value >= least && value <= most))
        refuse(name, text, allowed);
    return value;
}

static uint64_t read_seed(const char *text)
{
    char *end = NULL;
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (*end != '\0' || end == text || text[0] == '-' || text[0] == '+' || errno == ERANGE)
        refuse("seed", text, "0 to 18446744073709551615");
    return (uint64_t)value;
}

/* 0 or 1: which of two words stands there. */
static int read_choice(const char *name, const char *text, const char *zero, const char *one)
{
    char allowed[64];
    if (strcmp(text, zero) != 0 && strcmp(text, one) != 0) {
        snprintf(allowed, sizeof allowed, "%s, %s", zero, one);
        refuse(name, text, allowed);
    }
    return strcmp(text, one) == 0;
}

/* A setting that is a number; 0 if there is none of that name. */
static int take_number(rebound_settings_t *settings, const char *name, const char *value)
{
    if (strcmp(name, "half_size") == 0)
        settings->half_size = read_number(name, value, 1e-12, DBL_MAX, "a positive number");
    else if (strcmp(name, "gas_torque") == 0)
        settings->gas_torque = read_number(name, value, 0.0, DBL_MAX, "0 or a positive number");
    else if (strcmp(name, "tilt_deg") == 0)
        settings->roughness = fmin(
            read_number(name, value, 0.0, 0.5 / DEGREE, "0 to 28.6 deg") * DEGREE, 0.5);
    else if (strcmp(name, "Ra") == 0)
        settings->ra = read_number(name, value, 0.0, DBL_MAX, "0 or a positive length in m");
    else if (strcmp(name, "Rq") == 0)
        settings->rq = read_number(name, value, 0.0, DBL_MAX, "0 or a positive length in m");
    else if (strcmp(name, "RSm") == 0)
        settings->rsm = read_number(name, value, 1e-30, DBL_MAX, "a positive length in m");
    else
        return 0;
    return 1;
}

static void take(rebound_settings_t *settings, int *has_seed, const char *name, const char *value)
{
    if (strcmp(name, "table") == 0) {
        snprintf(settings->table, sizeof settings->table, "%s", value);
    } else if (strcmp(name, "seed") == 0) {
        settings->seed = read_seed(value);
        *has_seed = 1;
    } else if (strcmp(name, "spin") == 0) {
        settings->spin = read_choice(name, value, "no", "yes");
    } else if (strcmp(name, "out_of_range") == 0) {
        settings->refuse_outside = read_choice(name, value, "clamp", "error");
    } else if (!take_number(settings, name, value)) {
        refuse(name, "a name that is unknown",
               "table, seed, spin, out_of_range, half_size, gas_torque, tilt_deg, Ra, Rq, RSm");
    }
}

static void read_file(rebound_settings_t *settings)
{
    char line[512], name[64], value[256], more[2];
    int has_seed = 0;
    FILE *file = fopen(REBOUND_SETTINGS_FILE, "r");
    if (file == NULL)
        bft_error(__FILE__, __LINE__, 0, "%s: got no such file, allowed: one in DATA",
                  REBOUND_SETTINGS_FILE);
    while (fgets(line, sizeof line, file) != NULL) {
        line[strcspn(line, "#\n")] = '\0';
        const int words = sscanf(line, "%63s %255s %1s", name, value, more);
        if (words == 2)
            take(settings, &has_seed, name, value);
        else if (words > 0)
            refuse(name, words == 1 ? "no value" : "more than one value", "`name value`");
    }
    fclose(file);
    if (settings->table[0] == '\0')
        refuse("table", "none", "a file that `sampler export` wrote");
    if (!has_seed)
        refuse("seed", "none", "0 to 18446744073709551615");
}

/* Whether the table gives variable k of (u v w omega_x omega_y omega_z). */
static int gives(const rbt_table *table, int k)
{
    int columns[RBT_VALUES];
    const int n = rbt_components(table, columns);
    for (int i = 0; i < n; i++)
        if (columns[i] == k)
            return 1;
    return 0;
}

static void check_table(rebound_settings_t *settings, const rbt_table *table)
{
    const int has_spin = rbt_has_spin_law(table) && gives(table, 3) && gives(table, 4) &&
                         gives(table, 5);
    for (int k = 0; k < 3; k++)
        if (!gives(table, k))
            refuse("table", "one without all velocity components", "one with u, v, w");
    if (settings->spin == SPIN_IF_POSSIBLE)
        settings->spin = has_spin;
    if (settings->spin && !has_spin)
        refuse("spin", "yes", "no, with a table without spin law");
    if (!settings->spin && settings->gas_torque > 0.0)
        refuse("gas_torque", "a positive number", "0, where no spin is kept");
}

double rebound_settings_roughness(const rebound_settings_t *settings, double diameter)
{
    double tilt;
    if (settings->rsm <= 0.0)
        return settings->roughness;
    if (rbt_wall_tilt(settings->ra, settings->rq, settings->rsm, diameter, &tilt) < RBT_OK)
        refuse("RSm", "a profile whose facets are too steep", "Ra and Rq up to 0.27 RSm");
    return tilt;
}

/* A profile is whole, and right for particles of every size. */
static void check_profile(const rebound_settings_t *settings)
{
    const int profile = settings->ra > 0.0 || settings->rq > 0.0 || settings->rsm > 0.0;
    if (profile && settings->roughness > 0.0)
        refuse("tilt_deg", "a positive number beside a profile", "one of both");
    if (profile && settings->rsm <= 0.0)
        refuse("RSm", "none", "a positive length in m, with Ra and Rq");
    rebound_settings_roughness(settings, 1e-12 * settings->rsm);
    rebound_settings_roughness(settings, 1e12 * settings->rsm);
}

struct rbt_table *rebound_settings_read(rebound_settings_t *settings)
{
    const rebound_settings_t defaults = {.spin = SPIN_IF_POSSIBLE, .half_size = 0.5};
    rbt_table *table = NULL;
    *settings = defaults;
    read_file(settings);
    check_profile(settings);
    const int code = rbt_open(settings->table, &table);
    if (code < RBT_OK)
        bft_error(__FILE__, __LINE__, 0,
                  "%s: table: got %s, allowed: a file that `sampler export` wrote (%s)",
                  REBOUND_SETTINGS_FILE, settings->table, rbt_strerror(code));
    check_table(settings, table);
    return table;
}
