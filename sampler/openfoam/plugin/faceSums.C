#include "faceSums.H"
#include "mathematicalConstants.H"


Foam::faceSums::faceSums(const fvMesh& mesh, const word& cloud)
{
    const dimensionSet dims[6] = {dimless, dimless, dimMass, dimEnergy, dimEnergy, dimless};
    const char* names[6] = {"hits", "deposits", "mass", "energyBefore", "energyLost", "angle_deg"};

    // The name of the time, as all releases have it
    const dimensionedScalar& now = mesh.time();

    for (int i = 0; i < 6; ++i)
    {
        const word name(cloud + '_' + names[i]);

        if (!mesh.foundObject<volScalarField>(name))
        {
            const IOobject io
            (
                name, now.name(), mesh, IOobject::READ_IF_PRESENT, IOobject::AUTO_WRITE
            );
            const dimensionedScalar zero(name, dims[i], scalar(0));

            regIOobject::store(new volScalarField(io, mesh, zero));
        }
        sums_[i] = &mesh.lookupObjectRef<volScalarField>(name);
    }
}


void Foam::faceSums::add
(
    label patch, label face, scalar n, scalar mass, const vector& normal,
    const vector& before, const vector& after, bool stays
)
{
    const auto at = [=](const int i) -> scalar&
    {
        return sums_[i]->boundaryFieldRef()[patch][face];
    };
    const scalar energy = 0.5*mass*magSqr(before);
    const scalar angle = asin(min(-(before & normal)/mag(before), scalar(1)));

    at(0) += n;
    at(1) += stays ? n : 0;
    at(2) += mass;
    at(3) += energy;
    at(4) += energy - 0.5*mass*magSqr(after);
    at(5) += (angle*180/constant::mathematical::pi - at(5))*n/at(0);
}
