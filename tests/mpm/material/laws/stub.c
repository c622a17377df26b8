// SPDX-License-Identifier: GPL-2.0-or-later
// What MFront's generic interface exports of a behaviour, as TFEL 4 documents it: linear elasticity that sums up its
// strain (a tensor) and counts its calls. A negative Poisson's ratio fails.
#include <math.h>
#include <stdio.h>

#ifndef VERSION
#define VERSION "4.2.0"
#endif

typedef struct {
    const double* gradients;
    double* forces;
    const double *density, *properties;
    double *internal, *stored, *dissipated;
    const double* external;
} State;
typedef struct {
    char* error;
    double dt, *K, *rdt, *speed;
    State s0, s1;
} Data;

const char* Elastic_tfel_version = VERSION;
const char* Elastic_mfront_interface = "Generic";
unsigned short Elastic_BehaviourType = 1, Elastic_BehaviourKinematic = 1;
unsigned short Elastic_nMaterialProperties = 2, Elastic_nExternalStateVariables = 1;
const char* Elastic_MaterialProperties[] = {"YoungModulus", "PoissonRatio"};
const char* Elastic_ExternalStateVariables[] = {"Temperature"};
unsigned short Elastic_Tridimensional_nInternalStateVariables = 2;
const char* Elastic_Tridimensional_InternalStateVariables[] = {"Strain", "Calls"};
int Elastic_Tridimensional_InternalStateVariablesTypes[] = {1, 0};

int Elastic_Tridimensional(Data* d) {
    const double young = d->s1.properties[0], poisson = d->s1.properties[1];
    if (poisson < 0) {
        snprintf(d->error, 512, "PoissonRatio is below zero");
        return -1;
    }
    const double mu = young / (2 * (1 + poisson)), lambda = 2 * mu * poisson / (1 - 2 * poisson);
    double change[6], trace = 0;
    for (int k = 0; k < 6; ++k) {
        change[k] = d->s1.gradients[k] - d->s0.gradients[k];
        if (k < 3) trace += change[k];
        d->s1.internal[k] = d->s0.internal[k] + change[k];
    }
    d->s1.internal[6] = d->s0.internal[6] + 1;
    for (int k = 0; k < 6; ++k) d->s1.forces[k] = d->s0.forces[k] + 2 * mu * change[k] + (k < 3 ? lambda * trace : 0);
    if (d->K[0] > 3.5)
        for (int k = 0; k < 36; ++k)
            d->K[k] = (k % 7 == 0 ? 2 * mu : 0) + (k / 6 < 3 && k % 6 < 3 ? lambda : 0);
    return 1;
}
