/* Directional albedo of GGX lobes under single scattering: what is lost between microfacets, to be put back.
 *
 * Tables over roughness in [0, 1], mu = n.wo in (0, 1] and eta > 0, made by quadrature on first use (thread safe), linear in
 * between. Measured against the integrals for mu > 0.08, relative: reflection within 0.002; glass within 0.004 from outside
 * (eta >= 1) and 0.01 from inside, at any IOR from 1.001 to 5; Fresnel rise within 0.007 (absolute). For mu < 0.08 within
 * 0.04, but Fresnel rise within 0.02 (absolute), and glass from inside with an IOR below 1.01 within 0.1. Method: Kulla and
 * Conty (fresnel.h).
 *
 * From inside Cycles loses up to a tenth of the light at grazing angles: its table counts refractions that end on the
 * wrong side of the surface as light that came through, but its sampling drops them. Here they are lost light that is put
 * back, so that white glass is white from both sides.
 */
#ifndef BENT_SCENE_MICROFACET_ENERGY_H
#define BENT_SCENE_MICROFACET_ENERGY_H

/* Fills the tables, once per process (about 0.15 s; 200 KB). */
void microfacet_energy_prepare(void);

/* White reflection lobe. */
double microfacet_reflection_albedo(double roughness, double mu);
/* Cosine-weighted average of that over mu. */
double microfacet_reflection_average(double roughness);
/* Lossless glass: reflection and refraction together. */
double microfacet_glass_albedo(double roughness, double mu, double eta);
double microfacet_glass_average(double roughness, double eta);
/* Mean of fresnel_rise over the visible normals, 0 for those whose mirror direction is below the surface: what Cycles takes
 * from the layers below (precompute_ggx_gen_schlick_s in its app/cycles_precompute.cpp). */
double microfacet_fresnel_rise(double roughness, double mu, double eta);

#endif
