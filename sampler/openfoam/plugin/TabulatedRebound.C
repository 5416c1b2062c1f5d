#include "TabulatedRebound.H"
#include "meshTools.H"


// * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * * //

template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkComponents()
{
    const bool plane = this->mesh().nGeometricD() < 3;

    if (!table_->gives("u") || !table_->gives("v") || !(plane || table_->gives("w")))
    {
        FatalIOErrorInFunction(this->coefficients())
            << "tableFile: got a table without all velocity components, allowed: one with u, v"
            << (plane ? "" : ", w") << exit(FatalIOError);
    }

    givesSpin_ =
        table_->gives("omega_z")
     && (plane || (table_->gives("omega_x") && table_->gives("omega_y")));
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkHalfSize()
{
    // Only a spin depends on it, which a table without a spin law does not keep
    const scalar mean = table_->hasSpinLaw() ? table_->meanHalfSize() : 0.5;
    halfSizeRule_ = this->coefficients().template lookupOrDefault<scalar>("halfSizeRule", mean);

    if (!(halfSizeRule_ > 0))
    {
        FatalIOErrorInFunction(this->coefficients())
            << "halfSizeRule: got " << halfSizeRule_ << ", allowed: a positive number"
            << (mean > 0 ? "" : ", which a table with meshes needs") << exit(FatalIOError);
    }
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkDeposit()
{
    if (!this->coefficients().found("deposit")) return;

    const dictionary& dict = this->coefficients().subDict("deposit");

    depositSpeed_ = rebound::required<scalar>(dict, "speed");
    dict.readIfPresent("diameter", depositDiameter_);

    if (!(depositSpeed_ > 0) || !(depositDiameter_ >= 0))
    {
        FatalIOErrorInFunction(dict)
            << "deposit: got speed " << depositSpeed_ << ", diameter " << depositDiameter_
            << ", allowed: a positive speed and diameter" << exit(FatalIOError);
    }
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
        FatalIOErrorInFunction(this->coefficients())
            << "spin: got yes, allowed: no, with a table without "
            << (givesSpin_ ? "spin law" : "angular velocities") << exit(FatalIOError);
    }

    // Angular momenta are nobody else's
    if (spinOf::ofMomentum) return;

    const word dispersion =
        this->owner().subModelProperties().template lookupOrDefault<word>
        (
            "dispersionModel", "none"
        );

    if (dispersion != "none")
    {
        FatalIOErrorInFunction(this->coefficients())
            << "spin: got yes, allowed: no, with kinematic parcels and a dispersionModel (both need"
            << " UTurb of the parcels)" << exit(FatalIOError);
    }

    for (const polyPatch& pp : this->meshPatches())
    {
        if (!isA<coupledPolyPatch>(pp)) continue;

        const coupledPolyPatch& coupled = refCast<const coupledPolyPatch>(pp);

        if (rebound::turns(coupled) && !rebound::canFollow(coupled))
        {
            FatalIOErrorInFunction(this->coefficients())
                << "spin: got yes, allowed: no, with kinematic parcels and the rotating "
                << pp.type() << " patch " << pp.name() << exit(FatalIOError);
        }
    }
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::followSpin()
{
    const scalar gasTorque = this->coefficients().template lookupOrDefault<scalar>("gasTorque", 0);

    if (!(gasTorque >= 0) || (!keepsSpin_ && gasTorque > 0))
    {
        FatalIOErrorInFunction(this->coefficients())
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
                FatalIOErrorInFunction(this->coefficients())
                    << "gasTorque: got " << gasTorque << ", allowed: " << first
                    << ", as for other walls of this cloud" << exit(FatalIOError);
            }
            return;
        }
    }

    this->owner().functions().append(new SpinInFlight<CloudType>(this->owner(), gasTorque));
}


template<class CloudType>
bool Foam::TabulatedRebound<CloudType>::deposit
(
    parcelType& p,
    const vector& n,
    const vector& Uwall
)
{
    const scalar over = depositDiameter_ > 0 ? depositDiameter_/p.d() : 1;
    const scalar critical = depositSpeed_*pow(over, 10.0/7.0);

    if (!rbt_deposits(&p.U()[0], &n[0], critical, &Uwall[0])) return false;

    ++counts_.deposited;
    countHit(p);
    rebound::stop(p, 0);
    p.U() = Zero;
    spinOf::set(p, Zero);
    return true;
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
    const vector& omega,
    const polyPatch& pp,
    const int code
) const
{
    FatalErrorInFunction
        << "parcel (origProc, origId) = (" << p.origProc() << ", " << p.origId() << "), wall "
        << pp.name() << ": got velocity " << U << " m/s relative to the wall and spin " << omega
        << " rad/s, allowed: " << table_->range().c_str() << " ("
        << rbt_strerror(code < 0 ? code : RBT_CLAMPED) << ")"
        << exit(FatalError);
}


template<class CloudType>
typename Foam::TabulatedRebound<CloudType>::Counts
Foam::TabulatedRebound<CloudType>::totals() const
{
    const scalarField before
    (
        this->template getModelProperty<scalarField>("counts", scalarField(5, Zero))
    );

    return
    {
        int64_t(before[0]) + returnReduce(counts_.hits, sumOp<int64_t>()),
        int64_t(before[1]) + returnReduce(counts_.clamped, sumOp<int64_t>()),
        int64_t(before[3]) + returnReduce(counts_.extrapolated, sumOp<int64_t>()),
        int64_t(before[2]) + returnReduce(counts_.spinLost, sumOp<int64_t>()),
        int64_t(before[4]) + returnReduce(counts_.deposited, sumOp<int64_t>())
    };
}


// * * * * * * * * * * * * Protected Member Functions  * * * * * * * * * * * //

template<class CloudType>
void Foam::TabulatedRebound<CloudType>::report(Ostream* print, Ostream* table)
{
    const Counts all = totals();

    if (print)
    {
        *print
            << "    Tabulated rebounds (hits, clamped, extrapolated, spin lost, deposited) = "
            << all.hits << ", " << all.clamped << ", " << all.extrapolated << ", " << all.spinLost
            << ", " << all.deposited << endl;
    }

    if (table)
    {
        *table
            << tab << all.hits << tab << all.clamped << tab << all.extrapolated
            << tab << all.spinLost << tab << all.deposited << endl;
    }

    if (this->writeTime())
    {
        // As scalars: labels may have too few bits
        scalarField counts(5);
        counts[0] = all.hits;
        counts[1] = all.clamped;
        counts[2] = all.spinLost;
        counts[3] = all.extrapolated;
        counts[4] = all.deposited;
        this->setModelProperty("counts", counts);
        counts_ = {0, 0, 0, 0, 0};
    }
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::nameColumns(Ostream& table) const
{
    table << tab << "hits" << tab << "clamped" << tab << "extrapolated" << tab << "spinLost"
        << tab << "deposited";
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

template<class CloudType>
Foam::TabulatedRebound<CloudType>::TabulatedRebound(const dictionary& dict, CloudType& cloud)
:
    rebound::wallModel<CloudType>(dict, cloud, typeName),
    patches_(rebound::allPatches()),
    refuseOutside_(false),
    halfSizeRule_(0),
    roughness_(this->coefficients()),
    depositSpeed_(0),
    depositDiameter_(0),
    givesSpin_(false),
    keepsSpin_(false),
    counts_{0, 0, 0, 0, 0}
{
    const dictionary& coeffs = this->coefficients();

    const label seed = rebound::required<label>(coeffs, "seed");
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

    seed_ = seed;
    refuseOutside_ = (outside == "error");

    fileName path(rebound::required<fileName>(coeffs, "tableFile"));
    path.expand();

    if (!path.isAbsolute())
    {
        // Of the whole case, not of the part that one processor has
        path = this->mesh().time().globalPath()/path;
    }

    table_ = std::make_shared<reboundTable>(path, coeffs);

    checkComponents();
    checkHalfSize();
    checkDeposit();
    checkInjection();

    const bool can = table_->hasSpinLaw() && givesSpin_;
    keepsSpin_ = coeffs.template lookupOrDefault<Switch>("spin", can);
    if (keepsSpin_) checkSpin();

    followSpin();

    if (coeffs.template lookupOrDefault<Switch>("faceSums", false))
    {
        const bool works = table_->gives("work_normal") && roughness_.smooth();
        sums_ = std::make_shared<faceSums>(cloud.mesh(), cloud.name(), works);
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

template<class CloudType>
bool Foam::TabulatedRebound<CloudType>::correct
(
    parcelType& p,
    const polyPatch& pp,
    bool& keepParticle
)
{
    if (rebound::wallModelMeetsAll && keepsSpin_)
    {
        SpinInFlight<CloudType>::turn(this->owner(), p, pp);
    }

    if (!isA<wallPolyPatch>(pp) || !rebound::matches(patches_, pp.name()))
    {
        return false;
    }

    keepParticle = true;

    vector nOut, Uwall;
    this->owner().patchData(p, pp, nOut, Uwall);

    const vector Urelative(p.U() - Uwall);

    // On the wall but leaving it already. A velocity of NaN is an error, below
    if ((Urelative & nOut) <= 0) return true;

    ++counts_.hits;

    Pair<scalar> works(0, 0);
    const auto sum = [&](const vector& after, const bool stays)
    {
        const label face = pp.whichFace(p.face());
        const scalar n = p.nParticle();
        if (sums_)
        {
            sums_->add(pp.index(), face, n, n*p.mass(), nOut, Urelative, after, stays, works);
        }
    };

    if (deposit(p, -nOut, Uwall))
    {
        sum(Zero, true);
        return true;
    }

    const uint64_t identity = (uint64_t(uint32_t(p.origProc())) << 32) | uint32_t(p.origId());
    const scalar a = halfSizeRule_*p.d();

    const vector before(keepsSpin_ ? spinOf::get(p) : vector(Zero));
    const vector* spin = keepsSpin_ ? &before : nullptr;
    const uint32_t hit = countHit(p);
    vector omega(Zero);
    if (sums_ && sums_->works())
    {
        works = table_->works(p.U(), -nOut, Uwall, a, spin, seed_, identity, hit);
    }
    const int code = table_->rebound
    (
        p.U(), omega, -nOut, Uwall, a, roughness_.tilt(p.d()), roughness_.isotropic(),
        spin, seed_, identity, hit
    );

    if (code < 0 || ((code & RBT_CLAMPED) && refuseOutside_))
    {
        refuse(p, Urelative, before, pp, code);
    }

    sum(p.U() - Uwall, false);

    // A plane or wedge case cannot move a parcel out of its plane
    meshTools::constrainDirection(this->mesh(), this->mesh().geometricD(), p.U());

    if (code & RBT_CLAMPED) ++counts_.clamped;
    if (code & RBT_EXTRAPOLATED) ++counts_.extrapolated;

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
