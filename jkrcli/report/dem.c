/* Written by jkr: adhesive contact of $body;
   w = $w J/m^2. SI units; overlap and compressive force positive; the force of one contact.
   TOUCH: after first contact; TEAR: contact lost under displacement control, as in a particle code whose
   time step resolves it; LOAD: under load control. The interpolation is good to $error of the largest force and radius.
   $permission */
#if defined(${NAME}_H) && ${NAME}_H != $checksum
#error "another contact law named ${name} is included already: jkr export --dem --name"
#endif
#ifndef ${NAME}_H
#define ${NAME}_H $checksum
#include <math.h>
#define ${NAME}_ROWS $rows
#define ${NAME}_VECTORS $vectors
$numbers
static const double ${name}_force[${NAME}_ROWS] = {
$forces };
static const double ${name}_radius[${NAME}_ROWS] = {
$radii };
static const double ${name}_vector[${NAME}_VECTORS][3] = { /* delta, force, radius */
$vector };
/* The state at an overlap delta [m]; touching: whether the two were in contact before. Returns 1 in contact, 0 free,
   -1 beyond the table, where its last row stands in. */
static inline int ${name}_contact(double delta, int touching, double *force, double *radius)
{
    const int last = ${NAME}_ROWS - 1;
    double s, w[4];
    int i, k, found = 1;
    *force = *radius = 0.0;
    if (!(delta >= (touching ? ${NAME}_DELTA_TEAR : ${NAME}_DELTA_TOUCH))) return 0; /* also where delta is no number */
    s = sqrt(delta > ${NAME}_DELTA_TEAR ? (delta - ${NAME}_DELTA_TEAR) / ${NAME}_SPAN : 0.0) * last;
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
        *force += w[k] * ${name}_force[i + k];
        *radius += w[k] * ${name}_radius[i + k];
    }
    return found;
}

#ifdef ${NAME}_CHECK /* cc -D${NAME}_CHECK -x c this-file.h -lm && ./a.out: the law between its rows, and where contact ends */
#include <stdio.h>
int main(void)
{
    double force, radius, worst = 0.0;
    int n;
    for (n = 0; n < ${NAME}_VECTORS; n++) {
        if (${name}_contact(${name}_vector[n][0], 1, &force, &radius) != 1) return 1;
        worst = fmax(worst, fabs(force - ${name}_vector[n][1]) / ${NAME}_FORCE_SCALE);
        worst = fmax(worst, fabs(radius - ${name}_vector[n][2]) / ${NAME}_RADIUS_SCALE);
    }
    if (${name}_contact(${NAME}_DELTA_TOUCH - ${NAME}_SPAN * 1e-9, 0, &force, &radius) != 0) return 2;
    if (${name}_contact(${NAME}_DELTA_TEAR - ${NAME}_SPAN * 1e-9, 1, &force, &radius) != 0) return 3;
    if (${name}_contact(${NAME}_DELTA_TEAR + ${NAME}_SPAN * 1.1, 1, &force, &radius) != -1) return 4;
    printf("%.3g\n", worst);
    return worst > 2e-6 ? 5 : 0;
}
#endif
#endif
