/* The state of LANES curved rays inside one lens, shared by the files of the curved kernel (included by them only). */
#ifndef BENT_GEOMETRY_MARCH_H
#define BENT_GEOMETRY_MARCH_H
#include "geometry/query.h"
#include "geometry/travel.h"
#include "spacetime/arc.h"

/* Hits of chords that wait to be moved onto their arcs, one a lane. */
typedef struct landing {
  int count;
  unsigned leaving;           /* bits of lanes hit by the first chord from a surface */
  uint32_t target[LANES];
  found found[LANES];
  arc arc;                    /* each lane's own, and its ray at the beginning of it */
  arc_ray ray;
  lanes steps, tolerance;
  lanes low, high, from;      /* the chord: its offsets, and the ray's length at its beginning */
  lanes begin[3], span[3];    /* its world points */
} landing;

typedef struct march {
  const geometry *g;
  const lens *lens;
  arc_space space;
  double reach_w;    /* where w = 1/r is below this, neither geometry nor the edge of the lens can be met */
  int endless;       /* the lens is all of space */
  /* the rays of this call */
  const uint32_t *index;
  size_t count, loaded;
  const bent_ray *rays;
  traveler *travelers;
  bent_hit *hits;
  arc_ray ready;     /* launched rays that wait for a lane: those from ready_at on */
  int ready_at, ready_count;
  /* the rays in the lanes */
  arc_ray ray;
  unsigned busy;
  uint32_t target[LANES];
  lanes steps;
  lanes tolerance, arc_tolerance; /* of chords, world units; of the series, radians */
  lanes here[3];     /* where the next chord begins, world */
  lanes shift[3];    /* how far that is off the arc */
  lanes length;      /* so far, world units */
  lanes delta;       /* next chord to try, Mino time */
  lanes_mask blind;  /* nothing more to be hit */
  lanes_mask leaving; /* before the end of the first chord from a surface */
  lanes source[3], departure[3]; /* for leaving lanes: normal of the source triangle on the ray's side, direction drawn */
  landing landing;
} march;

/* How a lane's arc ended. One bit a lane. */
typedef struct outcome {
  lanes offset; /* where, unless in a hit */
  unsigned hit, edge, throat, away;
} outcome;

/* A position of the spacetime, [numerator, w] as from arc_position, in the world. */
LANES_INLINE void march_to_world(const march *m, const lanes numerator[3], lanes w, lanes out[3])
{
  const double(*a)[4] = m->lens->world_from_spacetime.m;
  const lanes r = 1 / w;
  for (int k = 0; k < 3; k++)
    out[k] = (a[k][0] * numerator[0] + a[k][1] * numerator[1] + a[k][2] * numerator[2]) * r + a[k][3];
}

/* World position at an offset of a ray's arc. */
LANES_INLINE void march_position(const march *m, const arc_ray *ray, const arc *arc, lanes offset, lanes out[3])
{
  lanes numerator[3], w;
  lanes_mask far;
  arc_position(&m->space, ray, arc, offset, numerator, &w, &far);
  march_to_world(m, numerator, w, out);
}

LANES_INLINE vec3 lane_vec3(const lanes a[3], int lane) { return v3(a[0][lane], a[1][lane], a[2][lane]); }

LANES_INLINE void set_lane_vec3(lanes a[3], int lane, vec3 value)
{
  a[0][lane] = value.x, a[1][lane] = value.y, a[2][lane] = value.z;
}

/* A lane's unit vector of the spacetime in the world. */
static vec3 march_direction(const march *m, const lanes a[3], int lane)
{
  return v3_normalize(mat4_vector(&m->lens->world_from_spacetime, lane_vec3(a, lane)));
}

LANES_INLINE lanes lanes_clamp(lanes x, double low, double high)
{
  return lanes_min(lanes_max(x, lanes_all(low)), lanes_all(high));
}

/* Lanes in which the ray moves outward (near side of a wormhole). `v` as in arc_ray. */
LANES_INLINE lanes_mask is_outward(const march *m, lanes v) { return m->space.kind == BENT_ELLIS ? v > 0 : v < 0; }
#endif
