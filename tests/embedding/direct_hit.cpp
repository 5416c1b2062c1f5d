// Rebounds at one hit by direct simulation, in C++; arguments and results as those of direct_hit.f90.

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_direct.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

static void bytes_of(std::fstream &file, std::vector<double> &numbers, bool written)
{
    char *const bytes = reinterpret_cast<char *>(numbers.data());
    const std::streamsize size = static_cast<std::streamsize>(numbers.size() * sizeof(double));
    if (!(written ? static_cast<bool>(file.write(bytes, size)) : static_cast<bool>(file.read(bytes, size))))
        std::exit(3);
}

int main(int, char **argv)
{
    const std::size_t n = std::strtoul(argv[3], nullptr, 10);
    std::vector<double> given(7 * n), results(10 * n);
    std::fstream impacts(argv[2], std::ios::binary | std::ios::in);
    bytes_of(impacts, given, false);

    rbt_table *table;
    int code = rbt_open(argv[1], &table);
    if (code == RBT_OK)
        code = rbt_use_direct(table, &rebound_direct);
    if (code < 0) {
        std::printf("%d %s\n", code, rbt_strerror(code));
        return 1;
    }
    for (std::uint64_t k = 0; k < n; k++) {
        const std::uint32_t hit = 0;
        double *row = &results[10 * k];
        rbt_impacts impact = {};
        rbt_rebounds after = {};
        impact.velocity = &given[7 * k];
        impact.normal = &given[7 * k + 3];
        impact.half_size = &given[7 * k + 6];
        impact.index = &k;
        impact.hit = &hit;
        after.velocity = row;
        after.omega = row + 3;
        after.inertia = row + 6;
        after.works = row + 7;
        code = rbt_rebound(table, 1, &impact, 7, &after);
        if (code < 0)
            return 2;
        row[9] = code;
    }
    rbt_close(table);
    std::fstream file(argv[4], std::ios::binary | std::ios::out);
    bytes_of(file, results, true);
    return 0;
}
