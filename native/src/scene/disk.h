/* The thin accretion disk of a black hole, written once for two compilers: C, and OSL's oslc, where REAL is float.
 *
 * A disk lies in the equatorial plane. Down to the innermost stable circular orbit (ISCO) its matter moves on circular
 * geodesics with the hole's rotation; farther in it falls freely from there (Cunningham 1975). Plain functions of numbers in
 * units of the hole's mass: no pointers, no structs. r: Boyer-Lindquist radius, outside the horizon; a: spin over mass, below
 * 1 in size, of which the disk follows the sign: azimuths are counted along the rotation and a >= 0 here. k_r and k_phi:
 * components of the unit direction in which light leaves the disk, in the frame of the local observer without angular
 * momentum (ZAMO). Formulas: Bardeen, Press & Teukolsky 1972 (BPT); Page & Thorne 1974. Relative errors in double
 * precision: about 1e-14 unless said otherwise.
 */
#ifndef BENT_SCENE_DISK_H
#define BENT_SCENE_DISK_H

#ifdef OSL_VERSION
#define REAL float
#define DISK_FUNCTION float
#define DISK_MAX max
#define DISK_NOISE(x, y, z) noise("perlin", point(x, y, z))
#else
#include <math.h>

#include "scene/noise.h"
#define REAL double
#define DISK_FUNCTION static inline double
#define DISK_MAX fmax
#define DISK_NOISE(x, y, z) noise_perlin((noise_point){3, {(float)(x), (float)(y), (float)(z)}})
#endif

/* ---- Orbits ---- */

/* r of a place of the equatorial plane from its distance to the hole as it is drawn (physics: charts). */
DISK_FUNCTION disk_radius_isotropic(REAL drawn) { return drawn * (1 + 0.5 / drawn) * (1 + 0.5 / drawn); }
DISK_FUNCTION disk_radius_oblate(REAL drawn, REAL a) { return sqrt(DISK_MAX(drawn * drawn - a * a, 0)); }
/* And back. */
DISK_FUNCTION disk_drawn_isotropic(REAL r) { return 0.5 * (r - 1 + sqrt(r * (r - 2))); }
DISK_FUNCTION disk_drawn_oblate(REAL r, REAL a) { return sqrt(r * r + a * a); }

/* Radius of the innermost stable circular orbit (BPT 2.21). */
DISK_FUNCTION disk_isco(REAL a)
{
  REAL third = 1.0 / 3.0;
  REAL z1 = 1 + pow((1 - a) * (1 + a), third) * (pow(1 + a, third) + pow(1 - a, third));
  REAL z2 = sqrt(3 * a * a + z1 * z1);
  return 3 + z2 - sqrt(DISK_MAX((3 - z1) * (3 + z1 + 2 * z2), 0));
}

/* dphi/dt of a circular orbit (BPT 2.16). */
DISK_FUNCTION disk_orbit_frequency(REAL r, REAL a) { return 1 / (r * sqrt(r) + a); }

/* Energy and angular momentum of circular orbits, per mass (BPT 2.12, 2.13). */
DISK_FUNCTION disk_orbit_binding(REAL r, REAL a) { return sqrt(1 - 3 / r + 2 * a / (r * sqrt(r))); }
DISK_FUNCTION disk_orbit_energy(REAL r, REAL a)
{
  return (1 - 2 / r + a / (r * sqrt(r))) / disk_orbit_binding(r, a);
}
DISK_FUNCTION disk_orbit_momentum(REAL r, REAL a)
{
  return sqrt(r) * (1 - 2 * a / (r * sqrt(r)) + a * a / (r * r)) / disk_orbit_binding(r, a);
}

/* ---- Local observers, in the equatorial plane (BPT 3.2 and following) ---- */

DISK_FUNCTION disk_delta(REAL r, REAL a) { return r * r - 2 * r + a * a; }
DISK_FUNCTION disk_circumference(REAL r, REAL a) { return sqrt(r * r + a * a + 2 * a * a / r); } /* sqrt(g_phiphi) */
DISK_FUNCTION disk_lapse(REAL r, REAL a) { return sqrt(disk_delta(r, a)) / disk_circumference(r, a); }
DISK_FUNCTION disk_drag(REAL r, REAL a)
{
  REAL around = disk_circumference(r, a);
  return 2 * a / (r * around * around);
}

/* ---- Shift of frequency ---- */

/* How much brighter light of an unknown spectrum is when its frequency is g times what it was: the sum over all
 * frequencies goes with g^4 (I(nu) dnu = g^3 I_emitted(nu / g) dnu). */
DISK_FUNCTION shifted_brightness(REAL g) { return g * g * g * g; }

/* Light's conserved energy, which is its frequency at infinity, over its frequency to the local observer. */
DISK_FUNCTION disk_gravitational(REAL r, REAL a, REAL k_phi)
{
  return disk_lapse(r, a) + disk_drag(r, a) * disk_circumference(r, a) * k_phi;
}

/* Light's frequency to the local observer over that in the frame of the disk's matter. */
DISK_FUNCTION disk_doppler(REAL r, REAL a, REAL k_r, REAL k_phi)
{
  REAL start = DISK_MAX(r, disk_isco(a)); /* of the fall; on circular orbits the place itself */
  REAL momentum = disk_orbit_momentum(start, a), along = momentum / disk_circumference(r, a);
  REAL gamma = (disk_orbit_energy(start, a) - disk_drag(r, a) * momentum) / disk_lapse(r, a);
  REAL inward = r < start ? sqrt(DISK_MAX(gamma * gamma - 1 - along * along, 0)) : 0;
  return 1 / (gamma - along * k_phi + inward * k_r);
}

/* ---- Page & Thorne 1974: the flux of a disk of steady accretion without torque at the ISCO ---- */

/* One of the three logarithms of eq. 15n. There the factor is 3 (x_i - a)^2 / (x_i ...), where x_i, a root of
 * x^3 - 3x + 2a, makes (x_i - a)^2 / x_i the same as x_i (x_i^2 - 1)^2 / 4, which stays finite without spin. */
DISK_FUNCTION disk_flux_term(REAL x, REAL x0, REAL root, REAL second, REAL third)
{
  REAL part = root * root - 1;
  return 0.75 * root * part * part / ((root - second) * (root - third)) * log((x - root) / (x0 - root));
}

/* Energy that each side of the disk radiates per area and time, in the frame of its matter, times 4 pi M^2 over the rate at
 * which mass falls in; 0 within the ISCO. Relative error: 1e-15 over the square of the distance to the ISCO,
 * in its radii; in single precision below 1e-3 from 1.2 ISCO radii on. a < 1. */
DISK_FUNCTION disk_flux(REAL r, REAL a)
{
  REAL inner = disk_isco(a);
  if (!(r > inner)) return 0;
  REAL x = sqrt(r), x0 = sqrt(inner), angle = acos(a);
  REAL x1 = 2 * cos((angle - M_PI) / 3), x2 = 2 * cos((angle + M_PI) / 3), x3 = -2 * cos(angle / 3);
  REAL bracket = x - x0 - 1.5 * a * log(x / x0) - disk_flux_term(x, x0, x1, x2, x3) - disk_flux_term(x, x0, x2, x1, x3) -
                 disk_flux_term(x, x0, x3, x1, x2);
  return DISK_MAX(1.5 * bracket / (r * x * x * (x * x * x - 3 * x + 2 * a)), 0);
}

/* ---- A pattern that the orbits shear ---- */

/* Octaves of noise around the hole, -1 to 1. */
DISK_FUNCTION disk_swirl(REAL azimuth, REAL height, REAL scale)
{
  REAL sum = 0, weight = 0.5, size = scale;
  for (int i = 0; i < 4; i++) {
    sum += weight * DISK_NOISE(size * cos(azimuth), size * sin(azimuth), size * height);
    weight *= 0.6;
    size *= 2.1;
  }
  return sum;
}

/* Noise of mean 0 and about -0.6 to 0.6, carried along by circular orbits, that comes back to itself when `phase` grows by 1.
 *
 * Two layers are torn out for a period each (in M), half a period apart, and fade in and out, so that neither is seen when
 * it starts afresh. Their weights are divided by what keeps the contrast the same. `scale`: features around the hole. */
DISK_FUNCTION disk_pattern(REAL r, REAL a, REAL azimuth, REAL phase, REAL period, REAL scale)
{
  REAL frequency = disk_orbit_frequency(DISK_MAX(r, disk_isco(a)), a), sum = 0, square = 0;
  for (int layer = 0; layer < 2; layer++) {
    REAL time = phase + 0.5 * layer;
    time -= floor(time);
    REAL weight = 1 - fabs(2 * time - 1), turned = azimuth - frequency * period * (time + 0.25);
    sum += weight * disk_swirl(turned, 3 * log(r) + 31.7 * layer, scale);
    square += weight * weight;
  }
  return sum / sqrt(square);
}

/* What a pattern multiplies light by: its mean is about 1. `contrast`: 4 is strong. */
DISK_FUNCTION disk_pattern_factor(REAL noise, REAL contrast)
{
  REAL deviation = 0.25 * contrast;
  return exp(contrast * noise - deviation * deviation / 2);
}

/* ---- Thermal light ---- */

/* Tables of blackbodies have ln of the luminance Y(T) with this added, which leaves something smooth, over equal steps of
 * ln T. 600 nm, in the middle of the visible, stands for all: h c / (k 600 nm). */
#define DISK_WIEN_KELVIN 23979.8
DISK_FUNCTION disk_luminance_stored(REAL luminance, REAL kelvin) { return log(luminance) + DISK_WIEN_KELVIN / kelvin; }
DISK_FUNCTION disk_luminance_from_stored(REAL stored, REAL kelvin) { return exp(stored - DISK_WIEN_KELVIN / kelvin); }

#undef REAL
#undef DISK_FUNCTION
#undef DISK_MAX
#undef DISK_NOISE
#endif
