/* Written by jkr: adhesive contact of $body;
   w = $w J/m^2. SI units; overlap and compressive force positive; the force of one contact.
   TOUCH: after first contact; TEAR: contact lost under displacement control, as in a particle code whose
   time step resolves it; LOAD: under load control. The interpolation is good to $error of the largest force and radius. */
#ifndef JKR_CONTACT_H
#define JKR_CONTACT_H
#include <math.h>
#define JKR_ROWS $rows
#define JKR_VECTORS $vectors
$numbers
static const double jkr_force[JKR_ROWS] = {
$forces };
static const double jkr_radius[JKR_ROWS] = {
$radii };
static const double jkr_vector[JKR_VECTORS][3] = { /* delta, force, radius */
$vector };
/* The state at an overlap delta [m]; touching: whether the two were in contact before. Returns 1 in contact, 0 free,
   -1 beyond the table, where its last row stands in. */
static inline int jkr_contact(double delta, int touching, double *force, double *radius)
{
    const int last = JKR_ROWS - 1;
    double s, w[4];
    int i, k, found = 1;
    *force = *radius = 0.0;
    if (delta < (touching ? JKR_DELTA_TEAR : JKR_DELTA_TOUCH)) return 0;
    s = sqrt(delta > JKR_DELTA_TEAR ? (delta - JKR_DELTA_TEAR) / JKR_SPAN : 0.0) * last;
    if (s > last * (1.0 + 1e-12)) { s = last; found = -1; }
    i = (int)s - 1;
    if (i < 0) i = 0;
    if (i > last - 3) i = last - 3;
    s -= i;
    w[0] = -(s - 1) * (s - 2) * (s - 3) / 6;
    w[1] = s * (s - 2) * (s - 3) / 2;
    w[2] = -s * (s - 1) * (s - 3) / 2;
    w[3] = s * (s - 1) * (s - 2) / 6;
    for (k = 0; k < 4; k++) {
        *force += w[k] * jkr_force[i + k];
        *radius += w[k] * jkr_radius[i + k];
    }
    return found;
}

#ifdef JKR_CHECK /* cc -DJKR_CHECK -x c this-file.h -lm && ./a.out: the law between its rows, and where contact ends */
#include <stdio.h>
int main(void)
{
    double force, radius, worst = 0.0;
    int n;
    for (n = 0; n < JKR_VECTORS; n++) {
        if (jkr_contact(jkr_vector[n][0], 1, &force, &radius) != 1) return 1;
        worst = fmax(worst, fabs(force - jkr_vector[n][1]) / JKR_FORCE_SCALE);
        worst = fmax(worst, fabs(radius - jkr_vector[n][2]) / JKR_RADIUS_SCALE);
    }
    if (jkr_contact(JKR_DELTA_TOUCH - JKR_SPAN * 1e-9, 0, &force, &radius) != 0) return 2;
    if (jkr_contact(JKR_DELTA_TEAR - JKR_SPAN * 1e-9, 1, &force, &radius) != 0) return 3;
    if (jkr_contact(JKR_DELTA_TEAR + JKR_SPAN * 1.1, 1, &force, &radius) != -1) return 4;
    printf("%.3g\n", worst);
    return worst > 2e-6 ? 5 : 0;
}
#endif
#endif
