/* Written by jkr: adhesive contact of particles of any size; $body.
   SI units; overlap and compressive force positive; the force of one contact. R: reduced radius, R1 R2/(R1 + R2) of two
   particles, that of the particle on a wall, from $low to $high m at w = $w J/m^2; w: work of adhesion. The table is
   P/(pi w R) and a/h over delta R/h^2 for values of q = w R^2/(E* h^3), h = $h m, E* = $E_star Pa.
   Force good to $force of its size + pi w R, radius to $radius of its size, ${name}_points
   to $points of pi w R and of the overlap of tear-off.
   $permission */
#if defined(${NAME}_H) && ${NAME}_H != $checksum
#error "another contact law named ${name} is included already: jkr export --dem --name"
#endif
#ifndef ${NAME}_H
#define ${NAME}_H $checksum
#include <math.h>
#define ${NAME}_SIZES $sizes
#define ${NAME}_ROWS $rows
#define ${NAME}_VECTORS $vectors
#define ${NAME}_W ($w)
#define ${NAME}_H_LAYER ($h)
#define ${NAME}_E_STAR ($E_star)
#define ${NAME}_PI 3.14159265358979323846
static const double ${name}_log_q[2] = { $log_q };
/* of each q: ln(-delta R/h^2) at tear-off, ln and power of the abscissa, pull-off under load control (delta over that
   of tear-off, P/(pi w R)), P/(pi w R) at first touch, energy lost over pi w R times the overlap of tear-off */
static const double ${name}_of_size[${NAME}_SIZES][7] = {
$of_size };
static const double ${name}_force[${NAME}_SIZES][${NAME}_ROWS] = {
$force_table };
static const double ${name}_radius[${NAME}_SIZES][${NAME}_ROWS] = { /* ln(a/h) */
$radius_table };
static const double ${name}_vector[${NAME}_VECTORS][5] = { /* R, w, delta, force, radius */
$vector };
/* A contact of one size: overlap and force where it is lost under displacement control (tear, as in a particle code whose
   time step resolves it) and under load control (load), force after first touch at delta = 0, energy lost from first
   touch to tear-off [J]. */
typedef struct { double delta_tear, force_tear, delta_load, force_load, force_touch, energy_lost; } ${name}_points;

/* The four rows about x in 0 ... 1 of a table of equal steps, and their weights in the cubic through them. */
static inline int ${name}_cubic(double x, int rows, double w[4])
{
    double s = x * (rows - 1);
    int i = (int)s - 1;
    if (i < 0) i = 0;
    if (i > rows - 4) i = rows - 4;
    s -= i;
    w[0] = -(s - 1) * (s - 2) * (s - 3) / 6;
    w[1] = s * (s - 2) * (s - 3) / 2;
    w[2] = -s * (s - 1) * (s - 3) / 2;
    w[3] = s * (s - 1) * (s - 2) / 6;
    return i;
}
/* The columns of a size: 1, or -2 beyond the table, where the nearest q stands in. */
static inline int ${name}_size(double R, double w, int *first, double weight[4], double column[7])
{
    const double h = ${NAME}_H_LAYER, q = w * R * R / (${NAME}_E_STAR * h * h * h);
    double y = (log(q) - ${name}_log_q[0]) / (${name}_log_q[1] - ${name}_log_q[0]);
    int i, k, found = 1;
    if (!(y >= -1e-9 && y <= 1.0 + 1e-9)) { found = -2; y = y > 1.0 ? 1.0 : 0.0; }
    *first = ${name}_cubic(y, ${NAME}_SIZES, weight);
    for (k = 0; k < 7; k++)
        for (column[k] = 0.0, i = 0; i < 4; i++) column[k] += weight[i] * ${name}_of_size[*first + i][k];
    return found;
}
static inline int ${name}_points_of(double R, double w, ${name}_points *points)
{
    const double unit = ${NAME}_PI * w * R;
    const ${name}_points none = { 0.0, 0.0, 0.0, 0.0, 0.0, 0.0 };
    double weight[4], column[7];
    int i, first, found = ${name}_size(R, w, &first, weight, column);
    *points = none;
    if (!(R > 0.0 && w > 0.0)) return -2;
    points->delta_tear = -exp(column[0]) * ${NAME}_H_LAYER * ${NAME}_H_LAYER / R;
    for (points->force_tear = 0.0, i = 0; i < 4; i++)
        points->force_tear += weight[i] * ${name}_force[first + i][0] * unit;
    points->delta_load = column[3] * points->delta_tear;
    points->force_load = column[4] * unit;
    points->force_touch = column[5] * unit;
    points->energy_lost = -column[6] * unit * points->delta_tear;
    return found;
}
/* The state at an overlap delta [m]; touching: whether the two were in contact before. Returns 1 in contact, 0 free,
   -1 beyond the largest overlap, -2 beyond the sizes; what is nearest in the table then stands in, and zeros where R or
   w is none. An overlap that is no number is free. */
static inline int ${name}_contact(double R, double w, double delta, int touching, double *force, double *radius)
{
    double weight[4], across[4], column[7], depth, u, s, f = 0.0, a = 0.0;
    int i, k, first, row, found = ${name}_size(R, w, &first, weight, column);
    const double tear = -exp(column[0]) * ${NAME}_H_LAYER * ${NAME}_H_LAYER / R;
    *force = *radius = 0.0;
    if (!(R > 0.0 && w > 0.0)) return -2;
    if (!(delta >= (touching ? tear : 0.0))) return 0;
    depth = (delta - tear) / -tear;
    u = asinh(sqrt(depth > 0.0 ? depth : 0.0));
    s = u / exp(column[1]);
    if (s > 1.0) { if (s > 1.0 + 1e-6 && found == 1) found = -1; s = 1.0; u = exp(column[1]); }
    row = ${name}_cubic(s, ${NAME}_ROWS, across);
    for (i = 0; i < 4; i++)
        for (k = 0; k < 4; k++) {
            f += weight[i] * across[k] * ${name}_force[first + i][row + k];
            a += weight[i] * across[k] * ${name}_radius[first + i][row + k];
        }
    *force = ${NAME}_PI * w * R * f * pow(cosh(u), 2.0 * column[2]);
    *radius = ${NAME}_H_LAYER * exp(a);
    return found;
}

#ifdef ${NAME}_CHECK /* cc -D${NAME}_CHECK -x c this-file.h -lm && ./a.out: the law between its rows and sizes */
#include <stdio.h>
int main(void)
{
    double force, radius, worst = 0.0, wide = 0.0;
    ${name}_points points;
    int n;
    for (n = 0; n < ${NAME}_VECTORS; n++) {
        const double *v = ${name}_vector[n];
        if (${name}_contact(v[0], v[1], v[2], 1, &force, &radius) != 1) return 1;
        worst = fmax(worst, fabs(force - v[3]) / (fabs(v[3]) + ${NAME}_PI * v[1] * v[0]));
        wide = fmax(wide, fabs(radius / v[4] - 1));
        ${name}_points_of(v[0], v[1], &points);
        if (${name}_contact(v[0], v[1], points.delta_tear * (1 + 1e-9), 1, &force, &radius) != 0) return 2;
        if (${name}_contact(v[0], v[1], points.delta_tear * 1e-9, 0, &force, &radius) != 0) return 3;
    }
    printf("%.3g %.3g\n", worst, wide);
    return worst > $force * 1.01 || wide > $radius * 1.01 ? 4 : 0;
}
#endif
#endif
