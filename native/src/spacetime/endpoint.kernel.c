/* The endpoint route, lane by lane: loads rays, asks the spacetime's solver, stores what the caller wants. */
#include "spacetime/endpoint.h"
#include "spacetime/endpoint_ellis.h"
#include "spacetime/endpoint_schwarzschild.h"

LANES_INLINE void store(const endpoint *end, size_t first, size_t count, const bent_trace_result *out)
{
  for (size_t i = 0; i < count; i++) {
    const size_t at = first + i;
    const bent_fate fate = (bent_fate)end->fate[i];
    const int escaped = fate == BENT_ESCAPED || fate == BENT_ESCAPED_FAR;
    if (out->fate) out->fate[at] = (uint8_t)fate;
    if (out->error) out->error[at] = escaped ? end->error[i] : fate == BENT_CAPTURED ? 0 : NAN;
    if (out->swept) out->swept[at] = escaped ? end->swept[i] : NAN;
    if (out->steps) out->steps[at] = 0;
    for (int k = 0; out->direction && k < 3; k++) out->direction[at][k] = escaped ? end->direction[k][i] : NAN;
  }
}

/* A ray whose arithmetic left the domain (an origin that is not in this spacetime, say) is declined. */
LANES_INLINE void decline_broken(endpoint *end)
{
  const lanes_mask sound = lanes_is_finite(end->error) & lanes_is_finite(end->swept);
  end->fate &= sound | (end->fate == BENT_CAPTURED);
}

void BENT_KERNEL(bent_trace_endpoint)(const bent_spacetime *spacetime, size_t n, const double (*origins)[3],
                                      const double (*directions)[3], double tolerance, const bent_trace_result *out)
{
  (void)tolerance;
  for (size_t first = 0; first < n; first += LANES) {
    lanes position[3], direction[3];
    lanes_load_rows(origins, NULL, first, n, position);
    lanes_load_rows(directions, NULL, first, n, direction);
    const aim a = aim_from(position, direction);
    endpoint end;
    if (spacetime->kind == BENT_SCHWARZSCHILD)
      end = endpoint_schwarzschild(spacetime->mass, spacetime->chart == BENT_CHART_ISOTROPIC, &a);
    else if (spacetime->kind == BENT_ELLIS)
      end = endpoint_ellis(spacetime->throat_radius, &a);
    else
      end = (endpoint){.fate = lanes_mask_all(0), .error = lanes_all(NAN)};
    decline_broken(&end);
    store(&end, first, n - first < LANES ? n - first : LANES, out);
  }
}
