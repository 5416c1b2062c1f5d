/* -- statistics by face of a wall ------------------------------------------------------------------

   What solvers write for each face of a wall: sums and histograms over the hits, for maps of deposits and
   of wear. Energies are those of translation relative to the wall, J. */

/* Impact angle from the wall, degrees. */
RBTI_INLINE RBT_DEVICE double rbti_angle_deg(const rbt_face_hit *hit)
{
    const double sine =
        -rbti_dot(hit->before, hit->normal) / sqrt(rbti_dot(hit->before, hit->before));
    return asin(sine < 1.0 ? sine : 1.0) * (180.0 / RBTI_PI);
}

RBT_API RBT_DEVICE void rbt_add_face_hit(const rbt_face_hit *hit, double *const sums[RBT_FACE_SUMS])
{
    const double mass = hit->number * hit->mass;
    const double energy = 0.5 * mass * rbti_dot(hit->before, hit->before);
    const double energy_after = 0.5 * mass * rbti_dot(hit->after, hit->after);
    double amounts[RBT_FACE_SUMS];
    amounts[RBT_FACE_HITS] = hit->number;
    amounts[RBT_FACE_DEPOSITS] = hit->stays ? hit->number : 0.0;
    amounts[RBT_FACE_MASS] = mass;
    amounts[RBT_FACE_ENERGY_BEFORE] = energy;
    amounts[RBT_FACE_ENERGY_LOST] = energy - energy_after;
    amounts[RBT_FACE_ANGLE_DEG] = 0.0; /* a mean, below */
    amounts[RBT_FACE_WORK_NORMAL] = mass * hit->works[0];
    amounts[RBT_FACE_WORK_SHEAR] = mass * hit->works[1];
    for (int k = 0; k < RBT_FACE_SUMS; k++)
        if (sums[k])
            *sums[k] += amounts[k];
    if (sums[RBT_FACE_ANGLE_DEG] && sums[RBT_FACE_HITS] && *sums[RBT_FACE_HITS] > 0.0) {
        double *mean = sums[RBT_FACE_ANGLE_DEG];
        *mean += (rbti_angle_deg(hit) - *mean) * hit->number / *sums[RBT_FACE_HITS];
    }
}

/* Bin of a value in a histogram from 0 to `most`; larger values belong to the last bin. */
RBTI_INLINE RBT_DEVICE int rbti_face_bin(double value, double most)
{
    const double bin = rbti_bounded(RBT_FACE_BINS * value / most, 0.0, RBT_FACE_BINS - 1.0);
    return (int)bin;
}

RBT_API RBT_DEVICE int rbt_angle_bin(const rbt_face_hit *hit)
{
    return rbti_face_bin(rbti_angle_deg(hit), 90.0);
}

RBT_API RBT_DEVICE int rbt_speed_bin(const rbt_face_hit *hit, double most_speed)
{
    return rbti_face_bin(sqrt(rbti_dot(hit->before, hit->before)), most_speed);
}
