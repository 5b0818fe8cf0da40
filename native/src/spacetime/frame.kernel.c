/* Local frames by the metric functions that rays are launched with (kerr.h): one place at a time, the same in every lane. */
#include "spacetime/frame.h"

#include "spacetime/arc.h"

static kerr_place place_of(const bent_spacetime *spacetime, const double position[3])
{
  const arc_space space = arc_space_make(spacetime);
  const lanes x[3] = {lanes_all(position[0]), lanes_all(position[1]), lanes_all(position[2])};
  kerr_place at;
  kerr_place_at(&space, x, &at);
  return at;
}

double BENT_KERNEL(bent_kerr_lapse)(const bent_spacetime *spacetime, const double position[3])
{
  const kerr_place at = place_of(spacetime, position);
  return kerr_lapse(&at)[0];
}

/* Each flat basis vector is stretched by (flat scale factor) / (curved one). */
void BENT_KERNEL(bent_kerr_local_from_covector)(const bent_spacetime *spacetime, const double position[3],
                                                double matrix[3][3])
{
  const kerr_place at = place_of(spacetime, position);
  lanes er[3], et[3], ep[3];
  kerr_chart_basis(&at, er, et, ep);
  const lanes outward = lanes_sqrt(at.delta) / at.stretch, eastward = at.stretch * lanes_sqrt(at.sigma / at.area);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      matrix[i][j] = (outward * er[i] * er[j] + et[i] * et[j] + eastward * ep[i] * ep[j])[0];
}
