/* Directional albedo of GGX lobes under single scattering: what is lost between microfacets, to be put back.
 *
 * Tables over roughness in [0, 1], mu = n.wo in (0, 1] and eta, made by quadrature on first use (thread safe), linear in
 * between. Measured against the integrals: reflection within 0.004; glass with eta or 1/eta in [1.2, 2.4] within 0.015,
 * for mu < 0.08 within 0.04; Fresnel rise within 0.004, for mu < 0.08 within 0.03. Method: Kulla and Conty (fresnel.h).
 */
#ifndef BENT_SCENE_MICROFACET_ENERGY_H
#define BENT_SCENE_MICROFACET_ENERGY_H

/* Fills the tables, once per process (about 0.15 s). */
void microfacet_energy_prepare(void);

/* White reflection lobe. */
double microfacet_reflection_albedo(double roughness, double mu);
/* Cosine-weighted average of that over mu. */
double microfacet_reflection_average(double roughness);
/* Lossless glass: reflection and refraction together. */
double microfacet_glass_albedo(double roughness, double mu, double eta);
double microfacet_glass_average(double roughness, double eta);
/* Mean of fresnel_rise over a reflection lobe. */
double microfacet_fresnel_rise(double roughness, double mu, double eta);

/* The integrals themselves. */
typedef struct microfacet_energy {
  double reflection, glass, rise;
} microfacet_energy;
microfacet_energy microfacet_integrate(double roughness, double mu, double eta, int samples);
#endif
