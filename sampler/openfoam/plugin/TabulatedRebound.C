#include "TabulatedRebound.H"
#include "meshTools.H"


// * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * * //

template<class CloudType>
Foam::fileName Foam::TabulatedRebound<CloudType>::inCase(fileName path) const
{
    path.expand();

    // Relative to the whole case, and not to the part of it that one processor has
    return path.empty() || path.isAbsolute() ? path : this->mesh().time().globalPath()/path;
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkVariables()
{
    const bool plane = this->mesh().nGeometricD() < 3;
    const auto has = [&](const int variable)
    {
        return rbt_has_variable(grains_.table.get(), variable) == 1;
    };

    rebound::need(has(RBT_U) && has(RBT_V) && (plane || has(RBT_W)), this->coefficients(),
        "tableFile", string("the table lacks a component of the velocity; give one with ")
          + (plane ? "u, v" : "u, v, w"));

    givesSpin_ = has(RBT_OMEGA_Z) && (plane || (has(RBT_OMEGA_X) && has(RBT_OMEGA_Y)));
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkHalfSize()
{
    // Only a spin depends on the half-size, and a table without a spin law keeps none
    const scalar mean = hasSpinLaw_ ? rbt_mean_half_size(grains_.table.get(), 1) : 0.5;
    const scalar given =
        this->coefficients().template lookupOrDefault<scalar>("halfSizeRule", mean);

    grains_.halfSizeRule = given;
    rebound::needValue(given > 0, this->coefficients(), "halfSizeRule", given,
        "a positive number");
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkDeposit()
{
    if (!this->coefficients().found("deposit")) return;

    const dictionary& dict = this->coefficients().subDict("deposit");

    depositSpeed_ = rebound::required<scalar>(dict, "speed");
    dict.readIfPresent("diameter", depositDiameter_);

    rebound::needValue(depositSpeed_ > 0, dict, "deposit.speed", depositSpeed_, "a positive number");
    rebound::needValue(depositDiameter_ >= 0, dict, "deposit.diameter", depositDiameter_,
        "a positive number");
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkInjection() const
{
    const dictionary& models =
        this->owner().subModelProperties().subOrEmptyDict("injectionModels");

    for (const entry& model : models)
    {
        if (!model.isDict()) continue;

        const word type = model.dict().template lookupOrDefault<word>("type", "none");

        rebound::need(type != "inflationInjection", models, "injectionModels",
            "inflationInjection and tabulatedRebound both need dTarget of the parcels; "
            "inject them another way");
    }
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::checkSpin() const
{
    const dictionary& coeffs = this->coefficients();

    rebound::need(hasSpinLaw_ && givesSpin_, coeffs, "spin",
        "the table has no spin law, or no angular velocities; write spin no");

    // No other model uses the angular momentum of parcels
    if (spinOf::ofMomentum) return;

    const word dispersion =
        this->owner().subModelProperties().template lookupOrDefault<word>
        (
            "dispersionModel", "none"
        );

    rebound::need(dispersion == "none", coeffs, "spin",
        "UTurb of a kinematic parcel keeps the spin, and the dispersionModel needs it, too; "
        "write spin no");

    for (const polyPatch& pp : this->meshPatches())
    {
        if (!isA<coupledPolyPatch>(pp)) continue;

        const coupledPolyPatch& coupled = refCast<const coupledPolyPatch>(pp);

        rebound::need(!rebound::turns(coupled) || rebound::canFollow(coupled), coeffs, "spin",
            "spins of kinematic parcels cannot be turned at the " + pp.type() + " patch " + pp.name()
          + "; write spin no");
    }
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::followSpin()
{
    const scalar gasTorque =
        this->coefficients().template lookupOrDefault<scalar>("gasTorque", keepsSpin_ ? 1 : 0);

    rebound::needValue(gasTorque >= 0, this->coefficients(), "gasTorque", gasTorque,
        "0 or a positive number");
    rebound::need(keepsSpin_ || gasTorque == 0, this->coefficients(), "gasTorque",
        "parcels keep no spin for the gas to slow; write gasTorque 0");

    if (!keepsSpin_) return;

    // If the cloud has another such model for other walls, that model has added the object already
    for (const CloudFunctionObject<CloudType>& other : this->owner().functions())
    {
        if (isA<SpinInFlight<CloudType>>(other))
        {
            const auto& first = refCast<const SpinInFlight<CloudType>>(other);

            rebound::needValue(first.gasTorque() == gasTorque, this->coefficients(), "gasTorque",
                gasTorque, Foam::name(first.gasTorque()) + ", as for other walls of this cloud");
            rebound::needValue(first.halfSizeRule() == grains_.halfSizeRule, this->coefficients(),
                "halfSizeRule", grains_.halfSizeRule,
                Foam::name(first.halfSizeRule()) + ", as for other walls of this cloud");
            return;
        }
    }

    this->owner().functions().append
    (
        new SpinInFlight<CloudType>(this->owner(), grains_, gasTorque)
    );
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::makeStatistics()
{
    const dictionary& coeffs = this->coefficients();

    if (coeffs.template lookupOrDefault<Switch>("faceSums", false))
    {
        statistics_.makeSums(rbt_has_variable(grains_.table.get(), RBT_WORK_NORMAL));
    }

    if (!coeffs.template lookupOrDefault<Switch>("faceHistograms", false)) return;

    const scalar highest = rbt_highest_speed(grains_.table.get());
    const scalar most = coeffs.template lookupOrDefault<scalar>("histogramSpeed", highest);

    rebound::needValue(most > 0, coeffs, "histogramSpeed", most,
        highest > 0 ? "a positive speed" : "a positive speed, which a table of any speed needs");
    statistics_.makeHistograms(most);
}


template<class CloudType>
bool Foam::TabulatedRebound<CloudType>::deposit
(
    parcelType& p,
    const vector& n,
    const vector& Uwall
)
{
    const scalar critical = rbt_critical_speed_at(p.d(), depositSpeed_, depositDiameter_);

    if (!rbt_deposits(&p.U()[0], &n[0], critical, &Uwall[0])) return false;

    ++counts_[DEPOSITED];
    rebound::countWall(p, 0);
    rebound::stop(p, 0);
    p.U() = Zero;
    spinOf::set(p, Zero);
    return true;
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::draw
(
    parcelType& p,
    const polyPatch& pp,
    const vector& n,
    const vector& Uwall,
    scalar* works
)
{
    const vector Urelative(p.U() - Uwall);
    const vector before(keepsSpin_ ? spinOf::get(p) : vector(Zero));
    const scalar inertiaBefore = rebound::inertia(p);
    const scalar a = grains_.halfSize(p);
    const scalar roughness = roughness_.tilt(p.d());
    const uint64_t index = rebound::identity(p);
    const uint32_t hit = rebound::wallsMet(p);
    vector omega(Zero);
    scalar inertia = 0;

    rbt_impacts impact = {};
    impact.velocity = &p.U()[0];
    impact.normal = &n[0];
    impact.half_size = &a;
    impact.wall_velocity = &Uwall[0];
    impact.omega = keepsSpin_ ? &before[0] : nullptr;
    impact.inertia = keepsSpin_ ? &inertiaBefore : nullptr;
    impact.roughness = &roughness;
    impact.index = &index;
    impact.hit = &hit;
    impact.fresh = !hasSpinLaw_;
    impact.isotropic = roughness_.isotropic();

    rbt_rebounds after = {};
    after.velocity = &p.U()[0];
    after.omega = &omega[0];
    after.inertia = &inertia;
    after.works = statistics_.hasWorks() ? works : nullptr;

    const int code = rbt_rebound(grains_.table.get(), 1, &impact, grains_.seed, &after);

    if (code < 0 || (refuseOutside_ && (code & RBT_OUTSIDE)))
    {
        FatalErrorInFunction
            << "parcel (origProc, origId) = (" << p.origProc() << ", " << p.origId() << "), wall "
            << pp.name() << ": got velocity " << Urelative << " m/s relative to the wall, half-size "
            << a << " m and spin " << before << " rad/s, allowed: "
            << rebound::covered(*grains_.table).c_str() << " ("
            << rbt_strerror(code) << ")" << exit(FatalError);
    }

    for (int kind = 0; kind < 4; ++kind)
    {
        counts_[ANGLE + kind] += after.flagged[kind];
    }

    rebound::countWall(p, keepsSpin_ ? inertia : 0);

    if (keepsSpin_ || (givesSpin_ && spinOf::ofMomentum))
    {
        spinOf::set(p, omega);
    }
}


// * * * * * * * * * * * * Protected Member Functions  * * * * * * * * * * * //

template<class CloudType>
void Foam::TabulatedRebound<CloudType>::report(Ostream* print, Ostream* table)
{
    // Sums are scalars, because labels may have too few bits
    scalarField all
    (
        this->template getModelProperty<scalarField>("counts", scalarField(COUNTS, Zero))
    );

    forAll(all, i)
    {
        all[i] += returnReduce(counts_[i], sumOp<scalar>());
    }

    if (print)
    {
        *print << "    Tabulated rebounds (hits, deposited, angle, speed, spin, extrapolated)";
        forAll(all, i) *print << (i ? ", " : " = ") << int64_t(all[i]);
        *print << endl;
    }

    if (table)
    {
        forAll(all, i) *table << tab << int64_t(all[i]);
        *table << endl;
    }

    if (this->writeTime())
    {
        this->setModelProperty("counts", all);
        for (scalar& count : counts_) count = 0;
    }
}


template<class CloudType>
void Foam::TabulatedRebound<CloudType>::nameColumns(Ostream& table) const
{
    table << tab << "hits" << tab << "deposited" << tab << "angle" << tab << "speed"
        << tab << "spin" << tab << "extrapolated";
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

template<class CloudType>
Foam::TabulatedRebound<CloudType>::TabulatedRebound(const dictionary& dict, CloudType& cloud)
:
    rebound::wallModel<CloudType>(dict, cloud, typeName),
    grains_{nullptr, 0, 0},
    patches_(rebound::allPatches()),
    refuseOutside_(false),
    roughness_(this->coefficients()),
    depositSpeed_(0),
    depositDiameter_(0),
    statistics_(cloud.mesh(), cloud.name()),
    hasSpinLaw_(false),
    givesSpin_(false),
    keepsSpin_(false),
    counts_{}
{
    const dictionary& coeffs = this->coefficients();

    const label seed = rebound::required<label>(coeffs, "seed");
    const word outside = coeffs.template lookupOrDefault<word>("outOfRange", "clamp");
    coeffs.readIfPresent("patches", patches_);

    rebound::needValue(seed >= 0, coeffs, "seed", seed, "0 to " + Foam::name(labelMax));
    rebound::needValue(outside == "clamp" || outside == "error", coeffs, "outOfRange", outside,
        "clamp, error");

    grains_.seed = seed;
    refuseOutside_ = (outside == "error");

    const fileName table(rebound::required<fileName>(coeffs, "tableFile"));
    const fileName direct(coeffs.template lookupOrDefault<fileName>("directFile", fileName()));

    grains_.table = rebound::openTable(inCase(table), inCase(direct), coeffs);
    hasSpinLaw_ = rbt_has_spin_law(grains_.table.get());

    checkVariables();
    checkHalfSize();
    checkDeposit();
    checkInjection();

    keepsSpin_ = coeffs.template lookupOrDefault<Switch>("spin", hasSpinLaw_ && givesSpin_);
    if (keepsSpin_) checkSpin();

    followSpin();

    makeStatistics();
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

    // The parcel leaves the wall already. If its velocity is NaN, the draw below refuses it
    if ((Urelative & nOut) <= 0) return true;

    ++counts_[HITS];

    scalar works[2] = {0, 0};
    const bool stays = deposit(p, -nOut, Uwall);

    if (!stays) draw(p, pp, -nOut, Uwall, works);

    const vector after(stays ? vector(Zero) : p.U() - Uwall);
    statistics_.add(p, pp, -nOut, Urelative, after, stays, works);

    // In a plane or wedge case no parcel may leave the plane
    meshTools::constrainDirection(this->mesh(), this->mesh().geometricD(), p.U());

    return true;
}
