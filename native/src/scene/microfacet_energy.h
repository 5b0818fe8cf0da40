/* Directional albedo of GGX lobes under single scattering: what is lost between microfacets, to be put back.
 *
 * Tables over roughness in [0, 1], mu = n.wo in (0, 1] and eta, made by quadrature on first use (thread safe), linear in
 * between; within 2e-3 of the integral for roughness >= 0.1. Kulla and Conty (see fresnel.h).
 */
#ifndef BENT_SCENE_MICROFACET_ENERGY_H
#define BENT_SCENE_MICROFACET_ENERGY_H

/* Fills the tables, once per process (about 50 ms). */
void microfacet_energy_prepare(void);

/* White reflection lobe. */
double microfacet_reflection_albedo(double roughness, double mu);
/* Cosine-weighted average of that over mu. */
double microfacet_reflection_average(double roughness);
/* Lossless glass: reflection and refraction together. */
double microfacet_glass_albedo(double roughness, double mu, double eta);
/* Mean of fresnel_rise over a reflection lobe. */
double microfacet_fresnel_rise(double roughness, double mu, double eta);

/* The integrals themselves. */
typedef struct microfacet_energy {
  double reflection, glass, rise;
} microfacet_energy;
microfacet_energy microfacet_integrate(double roughness, double mu, double eta, int samples);
#endif
