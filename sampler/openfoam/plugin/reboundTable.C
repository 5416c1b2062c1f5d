#define REBOUND_SAMPLER_IMPLEMENTATION
#include "samplerFunctions.H"

#include "reboundTable.H"
#include "compatibility.H"
#include "error.H"
#include "mathematicalConstants.H"
#include "stringOps.H"

static_assert(sizeof(Foam::scalar) == sizeof(double), "draws are in double precision");


std::shared_ptr<const rbt_table> Foam::rebound::openTable
(
    const fileName& path,
    const dictionary& coeffs
)
{
    rbt_table* table = nullptr;
    const int code = rbt_open(path.c_str(), &table);

    need(code >= 0, coeffs, "tableFile",
        string(path) + ": " + rbt_strerror(code) + "; give a file that `sampler export` wrote");

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
