/* Follows one ray arc by arc and evaluates it at given Mino times, LANES of them at once. */
#include "spacetime/path.h"

#include "spacetime/arc.h"

#define ARCS_MAX 2000

typedef struct path {
  const double *mino_times;
  size_t count, done;
  double (*positions)[3], (*directions)[3];
  uint8_t *sides;
} path;

/* Writes the points whose Mino times lie on this arc, which begins at `begin`. */
static void write_points(const arc_space *space, const arc_ray *ray, const arc *arc, double begin, path *path)
{
  const double end = begin + arc->step[0];
  while (path->done < path->count && path->mino_times[path->done] <= end) {
    const size_t first = path->done;
    lanes offset = {0}, numerator[3], w, direction[3];
    lanes_mask far;
    int points = 0;
    for (; points < LANES && first + points < path->count && path->mino_times[first + points] <= end; points++)
      offset[points] = path->mino_times[first + points] - begin;
    arc_position(space, ray, arc, offset, numerator, &w, &far);
    arc_direction(space, ray, arc, offset, direction);
    ellis_mirror(far, numerator);
    ellis_mirror(far, direction);
    for (int i = 0; i < points; i++, path->done++) {
      path->sides[path->done] = far[i] != 0;
      for (int k = 0; k < 3; k++) {
        path->positions[path->done][k] = numerator[k][i] / w[i];
        path->directions[path->done][k] = direction[k][i];
      }
    }
  }
}

void BENT_KERNEL(bent_march_path)(const bent_spacetime *spacetime, const double origin[3], const double direction[3],
                                  double tolerance, size_t n, const double *mino_times, double (*positions)[3],
                                  double (*directions)[3], uint8_t *sides)
{
  const arc_space space = arc_space_make(spacetime);
  path path = {mino_times, n, 0, positions, directions, sides};
  lanes from[3], look[3];
  arc_ray ray;
  arc arc;
  arc_load((const double(*)[3])origin, (const double(*)[3])direction, NULL, 0, 1, from, look);
  arc_launch(&space, from, look, &ray);
  double begin = 0;
  for (int arcs = 0; arcs < ARCS_MAX && path.done < n; arcs++) {
    arc_expand_to(&space, &ray, lanes_all(ARC_SHARE * tolerance), ARC_ORDER_MAX, &arc);
    arc_land(&space, &ray, &arc);
    write_points(&space, &ray, &arc, begin, &path);
    if (lanes_any(arc.escapes | arc.falls) || !(arc.step[0] > 0)) break;
    arc_advance(&space, &arc, arc.step, &ray);
    begin += arc.step[0];
  }
  for (; path.done < n; path.done++) {
    sides[path.done] = 0;
    for (int k = 0; k < 3; k++) positions[path.done][k] = directions[path.done][k] = NAN;
  }
}
