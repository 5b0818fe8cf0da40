/* How frequency and density of light change along rays: the frequency of light as places see it.
 *
 * Along a ray between places a and b, of frequencies nu, rays around it keep d(omega) dA nu^2 (solid angle and area across,
 * both as observers at rest measure them: Etherington 1933), so the spread from a to b (light/join.h) is that from b to a
 * times (nu_a / nu_b)^2. Radiance is carried as it is, without its g^3; a path traced from its light's end gathers
 * (nu_light / nu_camera)^2 on each arc instead. */
#ifndef BENT_LIGHT_FREQUENCY_H
#define BENT_LIGHT_FREQUENCY_H
#include "geometry/geometry.h"
#include "scene/shading.h"

/* nu at a place: 1 in flat space and far from a lone object, 1 / lapse around it. At the border of a finite sphere
 * directions go on as they are while lengths change their scale: nu holds what keeps the product above. */
double frequency_at(const geometry *g, vec3 position);
/* A ray as it left one place and came to another: directions local in world axes; swept: as in bent_hit. */
typedef struct frequency_leg {
  vec3 from, launch, to, arrival;
  double swept;
} frequency_leg;

/* The frequency that local observers (ZAMOs) measure at the start of a ray over that at its end. Straight space is as if at
 * infinity. Near a photon of energy 0, which only lives in ergospheres, it loses digits: 1e-15 over its part of the
 * local energy. */
double frequency_ratio(const geometry *g, const frequency_leg *leg);
/* Takes the history of a ray from where it started to where it has arrived. */
void frequency_follow(const geometry *g, const frequency_leg *leg, ray_history *ray);
/* The same for a ray that starts at a place and goes to the sky. */
void frequency_leave(const geometry *g, vec3 from, vec3 launch, ray_history *ray);
/* Whether nu is a function of the place alone: not if a wormhole's mouths are of different size. */
int frequency_is_of_place(const geometry *g);
#endif
