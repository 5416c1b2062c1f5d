#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "reboundTable.H"
#include "error.H"
#include "mathematicalConstants.H"
#include "stringOps.H"

static_assert(sizeof(Foam::scalar) == sizeof(double), "draws are in double precision");


Foam::reboundTable::reboundTable(const fileName& path, const dictionary& coeffs)
:
    table_(nullptr)
{
    const int code = rbt_open(path.c_str(), &table_);

    if (code < 0)
    {
        FatalIOErrorInFunction(coeffs)
            << "tableFile: got " << path << ", allowed: a file that `sampler export` wrote ("
            << rbt_strerror(code) << ")" << exit(FatalIOError);
    }
}


Foam::reboundTable::~reboundTable()
{
    rbt_close(table_);
}


bool Foam::reboundTable::gives(const word& component) const
{
    static const wordList names
    ({
        "u", "v", "w", "omega_x", "omega_y", "omega_z", "rotational_energy", "collisions", "work_normal"
    });

    int columns[RBT_VALUES];
    const int n = rbt_components(table_, columns);

    for (int i = 0; i < n; ++i)
    {
        if (columns[i] < names.size() && names[columns[i]] == component) return true;
    }

    return false;
}


bool Foam::reboundTable::hasSpinLaw() const
{
    return rbt_has_spin_law(table_);
}


Foam::scalar Foam::reboundTable::meanHalfSize() const
{
    return rbt_mean_half_size(table_, 1);
}


Foam::string Foam::reboundTable::range() const
{
    double alpha[2], speed[2];
    rbt_alpha_range(table_, alpha);
    rbt_speed_range(table_, speed);

    const scalar degrees = 180/constant::mathematical::pi;

    return string
    (
        name(alpha[0]*degrees) + " to " + name(alpha[1]*degrees) + " deg, "
      + name(speed[0]) + " to " + name(speed[1]) + " m/s"
    );
}


int Foam::reboundTable::rebound
(
    vector& U,
    vector& omega,
    const vector& n,
    const vector& Uwall,
    const scalar a,
    const scalar roughness,
    const bool isotropic,
    const vector* before,
    const uint64_t seed,
    const uint64_t particle,
    const uint32_t hit
) const
{
    return rbt_rebound_grain
    (
        table_, &U[0], &n[0], a, &Uwall[0], roughness, isotropic,
        before ? &(*before)[0] : nullptr, nullptr, seed, particle, hit, &U[0], &omega[0]
    );
}


Foam::Pair<Foam::scalar> Foam::reboundTable::works
(
    const vector& U,
    const vector& n,
    const vector& Uwall,
    const scalar a,
    const vector* before,
    const uint64_t seed,
    const uint64_t particle,
    const uint32_t hit
) const
{
    Pair<scalar> taken(0, 0);
    rbt_works
    (
        table_, &U[0], &n[0], a, &Uwall[0], before ? &(*before)[0] : nullptr, seed, particle, hit,
        &taken[0]
    );
    return taken;
}
