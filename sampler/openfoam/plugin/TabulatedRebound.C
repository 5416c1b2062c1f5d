#include "TabulatedRebound.H"
#include "meshTools.H"

namespace Foam
{
namespace tabulatedRebound
{

// Components of a state, as rebound_sampler.h counts them
enum component { u, v, w, omegaX, omegaY, omegaZ };

//- Give a parcel an angular velocity, as the angular momentum of a sphere of its diameter; false
//  for a parcel that has no place for one
template<class ParcelType>
auto storeSpin(ParcelType& p, const vector& omega, int)
    -> decltype(p.angularMomentum(), bool())
{
    p.angularMomentum() = p.momentOfInertia()*omega;
    return true;
}

template<class ParcelType>
bool storeSpin(ParcelType&, const vector&, long)
{
    return false;
}

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
    const scalarField before
    (
        this->template getModelProperty<scalarField>("counts", scalarField(3, Zero))
    );

    return
    {
        int64_t(before[0]) + returnReduce(counts_.hits, sumOp<int64_t>()),
        int64_t(before[1]) + returnReduce(counts_.clamped, sumOp<int64_t>()),
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
    counts_{0, 0, 0}
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

    vector omega(Zero);
    const int code =
        table_->rebound(p.U(), omega, -nOut, Uwall, a, seed_, identity, countHit(p));

    if (code < 0 || (code == reboundTable::clamped && refuseOutside_))
    {
        refuse(p, Urelative, pp, reboundTable::message(code));
    }

    // A plane or wedge case cannot move a parcel out of its plane
    const polyMesh& mesh = this->owner().mesh();
    meshTools::constrainDirection(mesh, mesh.geometricD(), p.U());

    ++counts_.hits;
    if (code == reboundTable::clamped) ++counts_.clamped;
    if (!givesSpin_ || !tabulatedRebound::storeSpin(p, omega, 0)) ++counts_.spinLost;

    return true;
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::info(Ostream& os)
{
    PatchInteractionModel<CloudType>::info(os);

    const Counts all = totals();

    os  << "    Tabulated rebounds (hits, clamped, spin lost) = "
        << all.hits << ", " << all.clamped << ", " << all.spinLost << endl;

    this->file() << tab << all.hits << tab << all.clamped << tab << all.spinLost << endl;

    if (this->writeTime())
    {
        // As scalars: labels may have too few bits
        scalarField counts(3);
        counts[0] = all.hits;
        counts[1] = all.clamped;
        counts[2] = all.spinLost;
        this->setModelProperty("counts", counts);
        counts_ = {0, 0, 0};
    }
}
