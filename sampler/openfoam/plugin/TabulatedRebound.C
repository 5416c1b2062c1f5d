#include "TabulatedRebound.H"
#include "cyclicACMIPolyPatch.H"
#include "meshTools.H"

namespace Foam
{
namespace tabulatedRebound
{

// Components of a state, as rebound_sampler.h counts them
enum component { u, v, w, omegaX, omegaY, omegaZ };

} // End namespace tabulatedRebound
} // End namespace Foam


// * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * * //

template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkComponents()
{
    namespace tr = tabulatedRebound;

    const bool plane = this->owner().mesh().nGeometricD() < 3;

    if (!table_->gives(tr::u) || !table_->gives(tr::v) || !(plane || table_->gives(tr::w)))
    {
        FatalIOErrorInFunction(this->coeffDict())
            << "tableFile: got a table without all velocity components, allowed: one with u, v"
            << (plane ? "" : ", w") << exit(FatalIOError);
    }

    givesSpin_ =
        table_->gives(tr::omegaZ)
     && (plane || (table_->gives(tr::omegaX) && table_->gives(tr::omegaY)));
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkInjection() const
{
    const dictionary& models =
        this->owner().subModelProperties().subOrEmptyDict("injectionModels");

    for (const entry& model : models)
    {
        if
        (
            model.isDict()
         && model.dict().template lookupOrDefault<word>("type", "none") == "inflationInjection"
        )
        {
            FatalIOErrorInFunction(models)
                << "injectionModels: got inflationInjection, allowed: any other with"
                << " tabulatedRebound (both need dTarget of the parcels)" << exit(FatalIOError);
        }
    }
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkSpin() const
{
    if (!table_->hasSpinLaw() || !givesSpin_)
    {
        FatalIOErrorInFunction(this->coeffDict())
            << "spin: got yes, allowed: no, with a table without "
            << (givesSpin_ ? "spin law" : "angular velocities") << exit(FatalIOError);
    }

    // Angular momenta are nobody else's
    if (spinOf::ofMomentum) return;

    if (this->owner().dispersion().active())
    {
        FatalIOErrorInFunction(this->coeffDict())
            << "spin: got yes, allowed: no, with kinematic parcels and a dispersionModel (both need"
            << " UTurb of the parcels)" << exit(FatalIOError);
    }

    for (const polyPatch& pp : this->owner().mesh().boundaryMesh())
    {
        // A parcel may go through one, which turns its spin, or meet the wall behind it
        if (isA<cyclicACMIPolyPatch>(pp) && !refCast<const coupledPolyPatch>(pp).parallel())
        {
            FatalIOErrorInFunction(this->coeffDict())
                << "spin: got yes, allowed: no, with kinematic parcels and the rotating cyclicACMI"
                << " patch " << pp.name() << exit(FatalIOError);
        }
    }
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::followSpin()
{
    const scalar gasTorque = this->coeffDict().template lookupOrDefault<scalar>("gasTorque", 0);

    if (!(gasTorque >= 0) || (!keepsSpin_ && gasTorque > 0))
    {
        FatalIOErrorInFunction(this->coeffDict())
            << "gasTorque: got " << gasTorque << ", allowed: 0"
            << (keepsSpin_ ? " or a positive number" : ", where no spin is kept")
            << exit(FatalIOError);
    }

    if (!keepsSpin_) return;

    // Models for other walls of the same cloud came first
    for (const CloudFunctionObject<CloudType>& other : this->owner().functions())
    {
        if (isA<SpinInFlight<CloudType>>(other))
        {
            const scalar first = refCast<const SpinInFlight<CloudType>>(other).gasTorque();

            if (first != gasTorque)
            {
                FatalIOErrorInFunction(this->coeffDict())
                    << "gasTorque: got " << gasTorque << ", allowed: " << first
                    << ", as for other walls of this cloud" << exit(FatalIOError);
            }
            return;
        }
    }

    this->owner().functions().append(new SpinInFlight<CloudType>(this->owner(), gasTorque));
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::reportWalls() const
{
    DynamicList<word> others;

    for (const polyPatch& pp : this->owner().mesh().boundaryMesh())
    {
        if (isA<wallPolyPatch>(pp) && !patches_.match(pp.name()))
        {
            others.append(pp.name());
        }
    }

    if (others.size())
    {
        Info<< "    tabulatedRebound: leaves walls " << others
            << " to another model of multiInteraction" << endl;
    }
}


template<class CloudType>
uint32_t Foam::TabulatedRebound<CloudType>::countHit(parcelType& p)
{
    const uint32_t hit = uint32_t(p.dTarget() + 0.5);
    p.dTarget() = scalar(hit) + 1;
    return hit;
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::refuse
(
    const parcelType& p,
    const vector& U,
    const polyPatch& pp,
    const char* why
) const
{
    FatalErrorInFunction
        << "parcel (origProc, origId) = (" << p.origProc() << ", " << p.origId() << "), wall "
        << pp.name() << ": got velocity " << U << " m/s relative to the wall, allowed: "
        << table_->range().c_str() << " (" << why << ")" << exit(FatalError);
}


template<class CloudType>
typename Foam::TabulatedRebound<CloudType>::Counts
Foam::TabulatedRebound<CloudType>::totals() const
{
    scalarField before
    (
        this->template getModelProperty<scalarField>("counts", scalarField(4, Zero))
    );

    // Releases up to 0.1 wrote three
    before.setSize(4, Zero);

    return
    {
        int64_t(before[0]) + returnReduce(counts_.hits, sumOp<int64_t>()),
        int64_t(before[1]) + returnReduce(counts_.clamped, sumOp<int64_t>()),
        int64_t(before[3]) + returnReduce(counts_.extrapolated, sumOp<int64_t>()),
        int64_t(before[2]) + returnReduce(counts_.spinLost, sumOp<int64_t>())
    };
}


// * * * * * * * * * * * * Protected Member Functions  * * * * * * * * * * * //

template<class CloudType>
void Foam::TabulatedRebound<CloudType>::writeFileHeader(Ostream& os)
{
    PatchInteractionModel<CloudType>::writeFileHeader(os);

    this->writeTabbed(os, "hits");
    this->writeTabbed(os, "clamped");
    this->writeTabbed(os, "extrapolated");
    this->writeTabbed(os, "spinLost");
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

template<class CloudType>
Foam::TabulatedRebound<CloudType>::TabulatedRebound(const dictionary& dict, CloudType& cloud)
:
    PatchInteractionModel<CloudType>(dict, cloud, typeName),
    patches_(List<wordRe>(1, wordRe(".*", wordRe::REGEX))),
    refuseOutside_(false),
    halfSizeRule_(this->coeffDict().template lookupOrDefault<scalar>("halfSizeRule", 0.5)),
    givesSpin_(false),
    keepsSpin_(false),
    counts_{0, 0, 0, 0}
{
    const dictionary& coeffs = this->coeffDict();

    const label seed = coeffs.template get<label>("seed");
    const word outside = coeffs.template lookupOrDefault<word>("outOfRange", "clamp");
    coeffs.readIfPresent("patches", patches_);

    if (seed < 0)
    {
        FatalIOErrorInFunction(coeffs)
            << "seed: got " << seed << ", allowed: 0 to " << labelMax << exit(FatalIOError);
    }
    if (outside != "clamp" && outside != "error")
    {
        FatalIOErrorInFunction(coeffs)
            << "outOfRange: got " << outside << ", allowed: clamp, error" << exit(FatalIOError);
    }
    if (!(halfSizeRule_ > 0))
    {
        FatalIOErrorInFunction(coeffs)
            << "halfSizeRule: got " << halfSizeRule_ << ", allowed: a positive number"
            << exit(FatalIOError);
    }

    seed_ = seed;
    refuseOutside_ = (outside == "error");

    fileName path(coeffs.template get<fileName>("tableFile"));
    path.expand();

    if (!path.isAbsolute())
    {
        // Of the whole case, not of the part that one processor has
        path = cloud.mesh().time().globalPath()/path;
    }

    table_ = std::make_shared<reboundTable>(path);

    checkComponents();
    checkInjection();

    const bool can = table_->hasSpinLaw() && givesSpin_;
    keepsSpin_ = coeffs.template lookupOrDefault<Switch>("spin", can);
    if (keepsSpin_) checkSpin();

    followSpin();
    reportWalls();
}


template<class CloudType>
Foam::TabulatedRebound<CloudType>::TabulatedRebound(const TabulatedRebound<CloudType>& model)
:
    PatchInteractionModel<CloudType>(model),
    table_(model.table_),
    seed_(model.seed_),
    patches_(model.patches_),
    refuseOutside_(model.refuseOutside_),
    halfSizeRule_(model.halfSizeRule_),
    givesSpin_(model.givesSpin_),
    keepsSpin_(model.keepsSpin_),
    counts_(model.counts_)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

template<class CloudType>
bool Foam::TabulatedRebound<CloudType>::correct
(
    parcelType& p,
    const polyPatch& pp,
    bool& keepParticle
)
{
    if (!isA<wallPolyPatch>(pp) || !patches_.match(pp.name()))
    {
        return false;
    }

    keepParticle = true;

    vector nOut, Uwall;
    this->owner().patchData(p, pp, nOut, Uwall);

    const vector Urelative(p.U() - Uwall);

    // On the wall but leaving it already. A velocity of NaN is an error, below
    if ((Urelative & nOut) <= 0) return true;

    const uint64_t identity = (uint64_t(uint32_t(p.origProc())) << 32) | uint32_t(p.origId());
    const scalar a = halfSizeRule_*p.d();

    const vector before(keepsSpin_ ? spinOf::get(p) : vector(Zero));
    vector omega(Zero);
    const int code = table_->rebound
    (
        p.U(), omega, -nOut, Uwall, a, keepsSpin_ ? &before : nullptr, seed_, identity, countHit(p)
    );

    if (code < 0 || (code == reboundTable::clamped && refuseOutside_))
    {
        refuse(p, Urelative, pp, reboundTable::message(code));
    }

    // A plane or wedge case cannot move a parcel out of its plane
    const polyMesh& mesh = this->owner().mesh();
    meshTools::constrainDirection(mesh, mesh.geometricD(), p.U());

    ++counts_.hits;
    if (code == reboundTable::clamped) ++counts_.clamped;
    if (table_->extrapolates(mag(Urelative))) ++counts_.extrapolated;

    if (keepsSpin_ || (givesSpin_ && spinOf::ofMomentum))
    {
        spinOf::set(p, omega);
    }
    else
    {
        ++counts_.spinLost;
    }

    return true;
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::info(Ostream& os)
{
    PatchInteractionModel<CloudType>::info(os);

    const Counts all = totals();

    os  << "    Tabulated rebounds (hits, clamped, extrapolated, spin lost) = "
        << all.hits << ", " << all.clamped << ", " << all.extrapolated << ", " << all.spinLost
        << endl;

    this->file()
        << tab << all.hits << tab << all.clamped << tab << all.extrapolated << tab << all.spinLost
        << endl;

    if (this->writeTime())
    {
        // As scalars: labels may have too few bits
        scalarField counts(4);
        counts[0] = all.hits;
        counts[1] = all.clamped;
        counts[2] = all.spinLost;
        counts[3] = all.extrapolated;
        this->setModelProperty("counts", counts);
        counts_ = {0, 0, 0, 0};
    }
}
