#include "rebound_sampler.h"

#include "depositRule.H"
#include "compatibility.H"
#include "error.H"


Foam::depositRule::depositRule(const dictionary& coeffs)
:
    speed_(0),
    diameter_(0),
    materials_{0, 0, 0, 0}
{
    if (!coeffs.found("deposit")) return;

    const dictionary& dict = coeffs.subDict("deposit");

    const auto positive = [&dict](const word& name)
    {
        const scalar value = rebound::required<scalar>(dict, name);

        if (!(value > 0))
        {
            FatalIOErrorInFunction(dict)
                << "deposit." << name << ": got " << value << ", allowed: a positive number"
                << exit(FatalIOError);
        }
        return value;
    };

    if (dict.found("speed"))
    {
        speed_ = positive("speed");
        if (dict.found("diameter")) diameter_ = positive("diameter");
        return;
    }

    const char* names[4] =
        {"youngsModulus", "poissonsRatio", "wallYoungsModulus", "wallPoissonsRatio"};

    for (int i = 0; i < 4; ++i) materials_[i] = positive(names[i]);
}


bool Foam::depositRule::keeps
(
    const vector& U, const vector& n, const vector& Uwall, scalar d, scalar rho
) const
{
    const scalar* m = materials_;
    const scalar critical =
        m[0] > 0 ? rbt_critical_speed(d, rho, m[0], m[1], m[2], m[3])
      : diameter_ > 0 ? speed_*pow(diameter_/d, 10.0/7.0)
      : speed_;

    return rbt_deposits(&U[0], &n[0], critical, &Uwall[0]);
}
