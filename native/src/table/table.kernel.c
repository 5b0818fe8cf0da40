/* Filling and reading deflection tables over SIMD lanes; the direct evaluation is that of the endpoint route. */
#include <string.h>

#include "spacetime/endpoint_ellis.h"
#include "spacetime/endpoint_schwarzschild.h"
#include "table/fit.h"
#include "table/table_data.h"

#define CRITICAL 5.19615242270663188058 /* b_c / M = sqrt(27) */

/* Direct evaluation ---------------------------------------------------------------------------------------------- */

LANES_INLINE lanes total_direct(const bent_table *table, lanes delta)
{
  const lanes b = 1 + delta, gap = lanes_abs(delta) * (2 + delta); /* |b^2 - 1| in units of the critical b */
  if (table->spacetime.kind == BENT_ELLIS)
    return 2 * b * half_pi_over_agm(lanes_max(b, lanes_all(1)), lanes_sqrt(gap));
  const lanes inverse_b2 = 1 / (27 * b * b);
  return sweep_with_barrier(gap / (b * b), inverse_b2, lanes_all(-1.0 / 3), lanes_all(0), inverse_b2,
                            lanes_mask_all(1));
}

LANES_INLINE endpoint sweep_direct(const bent_table *table, const aim *a)
{
  const bent_spacetime *s = &table->spacetime;
  return s->kind == BENT_ELLIS ? endpoint_ellis(s->throat_radius, a)
                               : endpoint_schwarzschild(s->mass, s->chart == BENT_CHART_ISOTROPIC, a);
}

/* Angle swept going out from position x (M/r or l/r) at an angle of cosine y > 0, over its sine. */
LANES_INLINE lanes outward_direct(const bent_table *table, lanes x, lanes y)
{
  aim a;
  memset(&a, 0, sizeof a);
  a.cosine = y, a.sine = lanes_sqrt((1 - y) * (1 + y));
  if (table->spacetime.kind == BENT_ELLIS) {
    a.radius = 0.5 * lanes_sqrt((1 + x) / (1 - x));
    return endpoint_ellis(1, &a).swept / a.sine;
  }
  a.radius = 1 / x;
  return endpoint_schwarzschild(1, 0, &a).swept / a.sine;
}

/* Filling -------------------------------------------------------------------------------------------------------- */

/* total at TABLE_WIDTH deltas */
static void total_direct_all(const bent_table *table, const double *deltas, double *out)
{
  for (int i = 0; i < TABLE_WIDTH; i += LANES) {
    lanes delta;
    memcpy(&delta, deltas + i, sizeof delta);
    const lanes total = total_direct(table, delta);
    memcpy(out + i, &total, sizeof total);
  }
}

void BENT_KERNEL(table_fill_total)(bent_table *table, size_t side, size_t octave, table_row_error *error)
{
  *error = (table_row_error){0};
  const double scale = ldexp(side ? -1 : 1, (int)octave + TABLE_EXPONENT_MIN);
  /* For Ellis delta > -1; the octaves beyond hold nothing that can be asked. */
  if (scale <= -1) return;
  for (int segment = 0; segment < TABLE_SEGMENTS; segment++) {
    double *row = table->total[side][octave * TABLE_SEGMENTS + segment];
    double deltas[TABLE_WIDTH], looked_up[TABLE_WIDTH], direct[TABLE_WIDTH];
    const double middle = 1 + (segment + 0.5) / TABLE_SEGMENTS, half = 0.5 / TABLE_SEGMENTS;
    for (int k = 0; k < TABLE_WIDTH; k++) deltas[k] = scale * (middle + half * chebyshev_node(k, TABLE_TERMS));
    total_direct_all(table, deltas, row);
    fit(row, 1, TABLE_TERMS);
    for (int k = 0; k < TABLE_WIDTH; k++) deltas[k] = scale * (middle + half * (2 * k + 1 - TABLE_WIDTH) / TABLE_WIDTH);
    total_direct_all(table, deltas, direct);
    BENT_KERNEL(table_total)(table, TABLE_WIDTH, deltas, looked_up);
    note_errors(looked_up, direct, TABLE_WIDTH, error);
  }
}

/* Reading -------------------------------------------------------------------------------------------------------- */

/* Beyond the segments: total = const - log|delta| toward the critical ray, and its series in 1/b far from it. */
LANES_INLINE lanes total_beyond(const bent_table *table, lanes size, lanes looked_up)
{
  const lanes tiny = looked_up - lanes_log(lanes_max(size * 0x1p44, lanes_all(1e-290)));
  const lanes inverse = 1 / (CRITICAL * (1 + size));
  const lanes huge = table->spacetime.kind == BENT_ELLIS ? lanes_all(M_PI)
                                                         : M_PI + inverse * (4 + 3.75 * M_PI * inverse);
  return lanes_select(size < 1, tiny, huge);
}

LANES_INLINE lanes total_lanes(const bent_table *table, lanes delta)
{
  const lanes size = lanes_abs(delta), low = lanes_all(0x1p-44), high = lanes_all(0x1.fffffffffffffp19);
  const lanes inside = lanes_min(lanes_max(size, low), high);
  const lanes_mask bits = (lanes_mask)inside;
  const int64_t base = (int64_t)(1023 + TABLE_EXPONENT_MIN) << TABLE_MANTISSA_BITS;
  const lanes_mask segment = (bits >> (52 - TABLE_MANTISSA_BITS)) - base;
  const lanes_mask below = (delta < 0) & (int64_t)(TABLE_OCTAVES * TABLE_SEGMENTS);
  const int64_t rest = (INT64_C(1) << (52 - TABLE_MANTISSA_BITS)) - 1;
  const lanes one_to = (lanes)((bits & rest) | 0x3ff0000000000000LL); /* 1 to 1 + 1/8 across the segment */
  const lanes x = (one_to - (1 + 0.5 / TABLE_SEGMENTS)) * (2 * TABLE_SEGMENTS);
  int64_t index[LANES];
  const lanes_mask at = segment + below;
  memcpy(index, &at, sizeof at);
  lanes angle = gather(table->total[0][0], TABLE_WIDTH, index, TABLE_TERMS - 1);
  for (int k = TABLE_TERMS - 2; k >= 0; k--) angle = angle * x + gather(table->total[0][0], TABLE_WIDTH, index, k);
  const lanes_mask beyond = inside != size;
  if (lanes_any(beyond)) angle = lanes_select(beyond, total_beyond(table, size, angle), angle);
  const lanes_mask exists = (delta > (table->sides > 1 ? -1 : 0)) & (delta != 0) & lanes_is_finite(delta);
  return lanes_select(exists, angle, lanes_all(NAN));
}

/* J at position x and |cosine| y inside the table's rectangle. */
LANES_INLINE lanes outward_lanes(const bent_table *table, lanes x, lanes y)
{
  const lanes across = (x - table->x_min) * (TABLE_X_CELLS / (table->x_max - table->x_min)), along = y * TABLE_Y_CELLS;
  const lanes_mask i = __builtin_convertvector(lanes_min(lanes_max(across, lanes_all(0)), lanes_all(TABLE_X_CELLS - 1)),
                                               lanes_mask);
  const lanes_mask j = __builtin_convertvector(lanes_min(along, lanes_all(TABLE_Y_CELLS - 1)), lanes_mask);
  const lanes s = 2 * (across - __builtin_convertvector(i, lanes)) - 1, t = 2 * (along - __builtin_convertvector(j, lanes)) - 1;
  const lanes_mask at = i * TABLE_Y_CELLS + j;
  int64_t index[LANES];
  memcpy(index, &at, sizeof at);
  const double *cells = table->outward[0][0][0];
  lanes sum = {0};
  for (int m = TABLE_X_TERMS - 1; m >= 0; m--) {
    const size_t first = (size_t)m * TABLE_WIDTH, width = TABLE_X_TERMS * TABLE_WIDTH;
    lanes row = gather(cells, width, index, first + TABLE_Y_TERMS - 1);
    for (int k = TABLE_Y_TERMS - 2; k >= 0; k--) row = row * t + gather(cells, width, index, first + k);
    sum = sum * s + row;
  }
  return sum;
}

/* J, or as the table has it, at TABLE_WIDTH cosines ys; times the sine if `swept`. */
static void outward_all(const bent_table *table, double x, const double *ys, int looked_up, int swept, double *out)
{
  for (int i = 0; i < TABLE_WIDTH; i += LANES) {
    lanes y;
    memcpy(&y, ys + i, sizeof y);
    lanes j = looked_up ? outward_lanes(table, lanes_all(x), y) : outward_direct(table, lanes_all(x), y);
    if (swept) j *= lanes_sqrt((1 - y) * (1 + y));
    memcpy(out + i, &j, sizeof j);
  }
}

void BENT_KERNEL(table_fill_outward)(bent_table *table, size_t x_cell, table_row_error *error)
{
  *error = (table_row_error){0};
  const double width = (table->x_max - table->x_min) / TABLE_X_CELLS, x_low = table->x_min + width * (double)x_cell;
  for (int y_cell = 0; y_cell < TABLE_Y_CELLS; y_cell++) {
    double(*cell)[TABLE_WIDTH] = table->outward[x_cell][y_cell];
    double ys[TABLE_WIDTH], looked_up[TABLE_WIDTH], direct[TABLE_WIDTH];
    for (int k = 0; k < TABLE_WIDTH; k++) ys[k] = (y_cell + 0.5 + 0.5 * chebyshev_node(k, TABLE_Y_TERMS)) / TABLE_Y_CELLS;
    for (int m = 0; m < TABLE_X_TERMS; m++) {
      const double x = x_low + width * (0.5 + 0.5 * chebyshev_node(m, TABLE_X_TERMS));
      outward_all(table, x, ys, 0, 0, cell[m]);
      fit(cell[m], 1, TABLE_Y_TERMS);
    }
    for (int k = 0; k < TABLE_Y_TERMS; k++) fit(&cell[0][k], TABLE_WIDTH, TABLE_X_TERMS);
    for (int k = 0; k < TABLE_WIDTH; k++) ys[k] = (y_cell + (k + 0.5) / TABLE_WIDTH) / TABLE_Y_CELLS;
    for (int m = 0; m < TABLE_X_TERMS; m++) {
      const double x = x_low + width * (m + 0.5) / TABLE_X_TERMS;
      outward_all(table, x, ys, 0, 1, direct);
      outward_all(table, x, ys, 1, 1, looked_up);
      note_errors(looked_up, direct, TABLE_WIDTH, error);
    }
  }
}

/* What a lookup knows of a ray: its place in the table and how it stands to the critical one. */
typedef struct table_place {
  lanes x, delta;
  lanes uncertain;       /* of delta */
  lanes_mask outside;    /* not in the rectangle of `outward` */
  lanes_mask outgoing, far, captured; /* far: ends on the far side of the throat */
} table_place;

LANES_INLINE table_place place_of(const bent_table *table, const aim *a)
{
  const bent_spacetime *s = &table->spacetime;
  table_place place;
  if (s->kind == BENT_ELLIS) {
    const lanes half = 0.5 * s->throat_radius / a->radius, inverse = 1 / (1 + half * half);
    const lanes p = (1 - half) * (1 + half) * inverse, c = 2 * half * inverse;
    place.x = lanes_abs(p), place.outgoing = a->cosine * p > 0;
    /* b = 0 straight through the throat lies on the edge of the segments. */
    place.delta = lanes_max((a->sine - c) / c, lanes_all(DBL_EPSILON - 1));
    place.uncertain = DBL_EPSILON * (4 + 2 / c) * (1 + place.delta);
    place.far = lanes_select(place.delta < 0, a->cosine, p) < 0;
    place.captured = (lanes_mask){0};
  } else {
    lanes lapse;
    if (s->chart == BENT_CHART_ISOTROPIC) {
      const lanes half = 0.5 * s->mass / a->radius, inverse = 1 / (1 + half);
      place.x = 2 * half * inverse * inverse, lapse = (1 - half) * inverse;
    } else {
      place.x = s->mass / a->radius, lapse = lanes_sqrt(1 - 2 * place.x);
    }
    const lanes inverse = 1 / (place.x * lapse), beta = a->sine * inverse;
    place.delta = (beta - CRITICAL) * (1 / CRITICAL), place.outgoing = a->cosine > 0;
    place.uncertain = DBL_EPSILON * (4 * beta + inverse);
    place.far = (lanes_mask){0}, place.captured = ~place.outgoing & ((place.delta < 0) | (place.x > 1.0 / 3));
  }
  place.outside = ~((place.x >= table->x_min) & (place.x <= table->x_max));
  return place;
}

LANES_INLINE lanes_mask fate_of(const table_place *place)
{
  const lanes_mask certain = place->outgoing | (lanes_abs(place->delta) > 4 * place->uncertain);
  const lanes_mask leaves = (place->far & BENT_ESCAPED_FAR) | (~place->far & BENT_ESCAPED);
  return certain & ((place->captured & BENT_CAPTURED) | (~place->captured & leaves));
}

/* Fate and swept angle of a ray to infinity. */
LANES_INLINE endpoint sweep_lanes(const bent_table *table, const aim *a)
{
  const table_place place = place_of(table, a);
  endpoint end;
  const lanes x = lanes_min(lanes_max(place.x, lanes_all(table->x_min)), lanes_all(table->x_max));
  const lanes outward = a->sine * outward_lanes(table, x, lanes_min(lanes_abs(a->cosine), lanes_all(1)));
  end.swept = outward;
  if (!lanes_every(place.outgoing))
    end.swept = lanes_select(place.outgoing, outward, total_lanes(table, place.delta) - outward);
  end.fate = fate_of(&place);
  end.error = 1e-15 + lanes_select(place.outgoing, lanes_all(0), place.uncertain / lanes_abs(place.delta));
  if (lanes_any(place.outside)) {
    const endpoint direct = sweep_direct(table, a);
    end.swept = lanes_select(place.outside, direct.swept, end.swept);
    end.error = lanes_select(place.outside, direct.error, end.error);
    end.fate = (place.outside & direct.fate) | (~place.outside & end.fate);
  }
  const lanes_mask sound = (a->radius > bent_spacetime_core_radius(&table->spacetime) * (table->sides == 1)) &
                           (lanes_abs(a->cosine) <= 1.001) & (a->sine >= 0) & (a->sine <= 1.001);
  end.fate &= sound;
  const lanes_mask leaves = (end.fate == BENT_ESCAPED) | (end.fate == BENT_ESCAPED_FAR);
  end.swept = lanes_select(leaves, end.swept, lanes_all(NAN));
  end.fate &= lanes_is_finite(end.swept) | (end.fate == BENT_CAPTURED);
  return end;
}

/* Loops over arrays ---------------------------------------------------------------------------------------------- */

/* LANES entries from `first`; beyond the end the last is repeated. */
LANES_INLINE lanes load(const double *from, size_t first, size_t n)
{
  lanes value;
  if (first + LANES <= n) memcpy(&value, from + first, sizeof value);
  else
    for (size_t i = 0; i < LANES; i++) value[i] = from[first + i < n ? first + i : n - 1];
  return value;
}

LANES_INLINE void save(double *to, size_t first, size_t n, lanes value)
{
  const size_t count = n - first < LANES ? n - first : LANES;
  memcpy(to + first, &value, count * sizeof *to);
}

void BENT_KERNEL(table_total)(const bent_table *table, size_t n, const double *delta, double *angle)
{
  for (size_t first = 0; first < n; first += LANES) save(angle, first, n, total_lanes(table, load(delta, first, n)));
}

void BENT_KERNEL(table_sweep)(const bent_table *table, size_t n, const double *radius, const double *cosine,
                              const double *sine, uint8_t *fate, double *swept)
{
  for (size_t first = 0; first < n; first += LANES) {
    aim a;
    memset(&a, 0, sizeof a);
    a.radius = load(radius, first, n), a.cosine = load(cosine, first, n), a.sine = load(sine, first, n);
    const endpoint end = sweep_lanes(table, &a);
    save(swept, first, n, end.swept);
    for (size_t i = 0; i < LANES && first + i < n; i++) fate[first + i] = (uint8_t)end.fate[i];
  }
}

void BENT_KERNEL(table_trace)(const bent_table *table, size_t n, const double (*origins)[3],
                              const double (*directions)[3], const bent_trace_result *out)
{
  bent_table_error measured = {0};
  bent_table_measured(table, &measured, NULL);
  for (size_t first = 0; first < n; first += LANES) {
    lanes position[3], direction[3];
    lanes_load_rows(origins, NULL, first, n, position);
    lanes_load_rows(directions, NULL, first, n, direction);
    const aim a = aim_from(position, direction);
    endpoint end = sweep_lanes(table, &a);
    end.error += measured.total_max + measured.sweep_max;
    endpoint_turn(&end, &a);
    endpoint_store(&end, first, n - first < LANES ? n - first : LANES, out);
  }
}
