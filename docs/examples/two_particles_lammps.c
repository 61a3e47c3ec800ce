/* Two coated particles of different sizes collide in LAMMPS, their contact by a header of `jkr export --dem --sizes`:
   fix external asks for the forces, LAMMPS integrates (its library interface; atom_style sphere, fix nve/sphere).

   jkr export coated.h5 --dem --sizes "1 um..100 um" --name all
   cc -I. docs/examples/two_particles_lammps.c -llammps -lm -o two && ./two

   Prints the kinetic energy lost, that of the header, the lowest force, and whether the two still touch. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include "all-dem.h"

void *lammps_open_no_mpi(int argc, char **argv, void **handle);
void lammps_close(void *lammps);
void lammps_commands_string(void *lammps, const char *commands);
double lammps_get_thermo(void *lammps, const char *keyword);
typedef void (*forces)(void *, int64_t, int, int *, double **, double **);
void lammps_set_fix_external_callback(void *lammps, const char *fix, forces callback, void *data);

typedef struct {
    double R[2];
    int touching;
    double lowest;
} pair;

/* Called in each time step: positions x in, forces f out. */
static void contact(void *data, int64_t step, int count, int *id, double **x, double **f)
{
    pair *both = data;
    double d[3], overlap = both->R[0] + both->R[1], distance = 0.0, force, radius;
    const double R = both->R[0] * both->R[1] / (both->R[0] + both->R[1]);
    int k;
    (void)step;
    (void)id;
    if (count != 2) exit(3);
    for (k = 0; k < 3; k++) {
        d[k] = x[1][k] - x[0][k];
        distance += d[k] * d[k];
    }
    distance = sqrt(distance);
    overlap -= distance;
    both->touching = jkr_all_contact(R, JKR_ALL_W, overlap, both->touching, &force, &radius);
    if (both->touching < 0) exit(4); /* beyond the table */
    if (force < both->lowest) both->lowest = force;
    for (k = 0; k < 3; k++) {
        f[1][k] = force * d[k] / distance;
        f[0][k] = -f[1][k];
    }
}

int main(void)
{
    char *words[] = { "two-particles", "-log", "none", "-screen", "none" }, commands[2000];
    pair both = { { 10e-6, 30e-6 }, 0, 0.0 };
    const double density = 2500.0, R = both.R[0] * both.R[1] / (both.R[0] + both.R[1]);
    jkr_all_points points;
    double before, after;
    void *lammps = lammps_open_no_mpi(5, words, NULL);
    if (lammps == NULL) return 2;
    jkr_all_points_of(R, JKR_ALL_W, &points);
    snprintf(commands, sizeof commands,
        "units si\natom_style sphere\natom_modify map array sort 0 0\nboundary f f f\n"
        "region box block -1e-4 2e-4 -1e-4 1e-4 -1e-4 1e-4\ncreate_box 1 box\n"
        "create_atoms 1 single 0 0 0\ncreate_atoms 1 single %.12g 0 0\n"
        "set atom 1 diameter %.12g density %g\nset atom 2 diameter %.12g density %g\n"
        "velocity all set 0 0 0\nset atom 1 vx 0.2\n"
        "pair_style zero 5e-5\npair_coeff * *\ncomm_modify vel yes\n"
        "neighbor 1e-5 bin\nfix integrate all nve/sphere\nfix contact all external pf/callback 1 1\n"
        "timestep 1e-11\nthermo 100000\n", 1.0001 * (both.R[0] + both.R[1]),
        2 * both.R[0], density, 2 * both.R[1], density);
    lammps_commands_string(lammps, commands);
    lammps_set_fix_external_callback(lammps, "contact", contact, &both);
    lammps_commands_string(lammps, "run 0");
    before = lammps_get_thermo(lammps, "ke");
    lammps_commands_string(lammps, "run 200000");
    after = lammps_get_thermo(lammps, "ke");
    printf("%.6e %.6e %.6e %d\n", before - after, points.energy_lost, both.lowest, both.touching);
    lammps_close(lammps);
    return 0;
}
