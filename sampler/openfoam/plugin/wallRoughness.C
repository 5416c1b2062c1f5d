#include "samplerFunctions.H"

#include "wallRoughness.H"
#include "compatibility.H"
#include "error.H"
#include "mathematicalConstants.H"
#include "Switch.H"


Foam::wallRoughness::wallRoughness(const dictionary& coeffs)
:
    tilt_(0),
    Ra_(0),
    Rq_(0),
    RSm_(0),
    isotropic_(false)
{
    if (!coeffs.found("roughness")) return;

    const dictionary& dict = coeffs.subDict("roughness");

    isotropic_ = dict.lookupOrDefault<Switch>("isotropic", false);

    if (!dict.found("tilt_deg"))
    {
        Ra_ = rebound::required<scalar>(dict, "Ra");
        Rq_ = rebound::required<scalar>(dict, "Rq");
        RSm_ = rebound::required<scalar>(dict, "RSm");
        tilt_ = -1;
        return;
    }

    const scalar degree = constant::mathematical::pi/180;
    const scalar degrees = rebound::required<scalar>(dict, "tilt_deg");

    tilt_ = degrees*degree;

    rebound::needValue(tilt_ >= 0 && tilt_ <= RBT_MOST_ROUGHNESS, dict, "roughness.tilt_deg", degrees,
        "0 to " + name(RBT_MOST_ROUGHNESS/degree));
}


Foam::scalar Foam::wallRoughness::tilt(const scalar d) const
{
    if (tilt_ >= 0) return tilt_;

    double tilt = 0;

    if (rbt_wall_tilt(Ra_, Rq_, RSm_, d, &tilt) != RBT_OK)
    {
        FatalErrorInFunction
            << "roughness: got Ra " << Ra_ << ", Rq " << Rq_ << ", RSm " << RSm_
            << " m and a parcel of diameter " << d << " m, allowed: lengths from 0, RSm above 0, and"
            << " a tilt up to " << RBT_MOST_ROUGHNESS << " rad" << exit(FatalError);
    }

    return tilt;
}
