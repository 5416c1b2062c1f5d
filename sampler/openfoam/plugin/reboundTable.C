#define REBOUND_SAMPLER_IMPLEMENTATION
#include "samplerFunctions.H"

#include "reboundTable.H"
#include "compatibility.H"
#include "error.H"
#include "mathematicalConstants.H"
#include "stringOps.H"

#include <dlfcn.h>

static_assert(sizeof(Foam::scalar) == sizeof(double), "draws are in double precision");


namespace
{

//- Let a table simulate, by the law in a shared library. The law must outlive all copies of the table,
//  so the library stays open
void useDirect(rbt_table* table, const Foam::fileName& path, const Foam::dictionary& coeffs)
{
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    const void* const law = library ? dlsym(library, "rebound_direct") : nullptr;
    const char* const problem = law ? "" : dlerror();

    Foam::rebound::need(law, coeffs, "directFile", Foam::string(problem)
      + "; run: tablegen export-direct PAIR --output DIR, "
        "and in DIR: gcc -shared rebound_direct.o -lm -o rebound_direct.so");

    const int code = rbt_use_direct(table, static_cast<const rbt_direct_law*>(law));

    Foam::rebound::need(code == RBT_OK, coeffs, "directFile",
        Foam::string(path) + ": " + rbt_strerror(code));
}

} // End anonymous namespace


std::shared_ptr<const rbt_table> Foam::rebound::openTable
(
    const fileName& path,
    const fileName& direct,
    const dictionary& coeffs
)
{
    rbt_table* table = nullptr;
    const int code = rbt_open(path.c_str(), &table);

    need(code >= 0, coeffs, "tableFile",
        string(path) + ": " + rbt_strerror(code) + "; give a file that `sampler export` wrote");

    if (!direct.empty()) useDirect(table, direct, coeffs);

    return std::shared_ptr<const rbt_table>(table, rbt_close);
}


Foam::string Foam::rebound::covered(const rbt_table& table)
{
    rbt_range range;
    rbt_covered(&table, &range);

    const scalar degrees = 180/constant::mathematical::pi;
    const auto span = [](const scalar from, const scalar to, const char* unit)
    {
        return name(from) + " to " + name(to) + unit;
    };

    return
        span(range.alpha1[0]*degrees, range.alpha1[1]*degrees, " deg, ")
      + span(range.speed[0], range.speed[1], " m/s, spins of ")
      + span(range.spin[0], range.spin[1], " V/a");
}
