/* One scattering of a walk below a surface, in a medium without end: the core's own step, many times. */
#include "render/subsurface.c"

/* Nothing is ever met; the random numbers are the caller's. */
int geometry_query(const geometry *g, const query *q, found *f) { return (void)g, (void)q, (void)f, 0; }
double flat_land(const geometry *g, const found *f, vec3 start, vec3 direction, bent_hit *hit)
{
  return (void)g, (void)f, (void)start, (void)direction, (void)hit, 0;
}
void sampler_draw(const sampler *sampler, sampler_pixel pixel, uint32_t sample, uint32_t set, double u[SAMPLER_DIMENSIONS])
{
  (void)sampler, (void)pixel, (void)sample, (void)set, (void)u;
}

/* Of a walk along `direction` with that light: n steps, each from the start, by u[i]; where each one ends, and its light. Returns
 * the diffusion length of the guide along `normal`. */
double walk_steps(size_t n, const double extinction[3], const double albedo[3], double anisotropy, const double light[3],
                  const double direction[3], const double normal[3], double guided, int is_first,
                  const double (*u)[SAMPLER_DIMENSIONS], double (*position)[3], double (*left)[3])
{
  medium m = {.anisotropy = anisotropy};
  for (int k = 0; k < 3; k++) m.extinction[k] = extinction[k], m.albedo[k] = albedo[k];
  const guide towards = guide_of(&m, v3_from(normal));
  instance inside = {0};
  const geometry g = {.instances = &inside};
  const bent_hit entry = {.instance = 0};
  for (size_t i = 0; i < n; i++) {
    walk w = {.direction = v3_from(direction), .light = {light[0], light[1], light[2]}};
    bent_hit exit;
    step(&g, &m, &towards, &entry, is_first, u[i], guided, &w, &exit);
    v3_to(position[i], w.position);
    for (int k = 0; k < 3; k++) left[i][k] = w.light[k];
  }
  return towards.length;
}
